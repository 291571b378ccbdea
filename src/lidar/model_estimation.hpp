#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "lidar/ring_recovery.hpp"
#include <mapless/lidar/lidar_model.hpp>

namespace mapless::inline v1 {

/// What is known of the sensor beforehand.
struct ModelEstimationOptions {
  std::string name = "estimated";
  double rotation_rate_hz = 10;
  SpinDirection direction = SpinDirection::clockwise;
  double start_azimuth_rad = 3.14159265358979323846;  ///< of the seam
  double min_range_m = 0;
  double max_range_m = 120;  ///< HDL-64E
  int expected_rings = 64;   ///< preferred where scans differ in their number of rings
};

struct EstimatedModel {
  LidarModel model;
  BareCloudLayout layout;
  ModelEstimate estimate;
};

/// An uncompensated cloud of which the ring of every point is known, points of a ring by rising atan2(y, x).
struct RingedCloud {
  std::vector<Eigen::Vector3f> points;
  std::vector<std::int32_t> rings;  ///< one a point; negative: not to be used
};

/// Estimates every laser from a few uncompensated bare clouds of one sensor, stored ring after ring.
///
/// Elevation and vertical origin: a robust line z = z_0 + rho tan(elevation) through each ring, rho =
/// hypot(x, y). Where along its own beam a laser starts cannot be seen; the origin is put above the spin axis
/// (beside it, below). Azimuth: the angle encoder of the hub leaves the azimuths on a grid, once the
/// horizontal origin h of the laser is allowed for, azimuth = hub angle + offset + asin(h / rho). Its step,
/// then h and the phase of each ring, are those that concentrate the azimuths most on the grid. All lasers
/// fire at the same encoder positions: where these are irregular, they give the whole offsets too, but for
/// one turn common to all, which is taken to centre them on 0. Throws InputError naming `source` where no
/// rings are found.
[[nodiscard]] EstimatedModel estimate_model(const std::vector<std::vector<Eigen::Vector3f>>& clouds,
                                            const ModelEstimationOptions& options, const std::string& source);

/// The same from clouds whose rings are known, 0 to `ring_count` - 1; layout.row_of_ring tells the row of
/// each.
[[nodiscard]] EstimatedModel estimate_model_of_rings(const std::vector<RingedCloud>& clouds,
                                                     std::size_t ring_count,
                                                     const ModelEstimationOptions& options,
                                                     const std::string& source);

}  // namespace mapless
