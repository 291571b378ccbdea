#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

#include <mapless/lidar/lidar_model.hpp>
#include <mapless/lidar/ring_recovery.hpp>

namespace mapless::inline v1 {

/// What `mapless info` says of how the rings, angles and origins of a bare cloud's lasers were found.
struct ModelEstimate {
  int scans_used = 0;
  double elevation_residual_m =
      0;  ///< RMS height of the points over their laser's fitted cone (central 95 %)
  double azimuth_residual_columns = 0;  ///< RMS distance of the points from their column's centre, in columns
  int lasers_borrowed = 0;  ///< lasers whose vertical origin (or all) is interpolated from their neighbours
  int encoder_steps = 0;    ///< positions of the hub's encoder found in the azimuths; 0: none
  int azimuths_known = 0;   ///< lasers whose azimuth offset was found, else taken as 0
  /// The offsets are true ones, found from the sensor's irregular firing positions. Otherwise only the part
  /// of each that is less than a column is known: a uniform grid of columns looks the same turned by one.
  bool azimuths_absolute = false;
};

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
