#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "lidar/recovery/ring_points.hpp"
#include "lidar/recovery/ring_recovery.hpp"
#include <mapless/lidar/lidar_model.hpp>

namespace mapless::inline v1 {

/// Prior knowledge of the sensor.
struct ModelEstimationOptions {
  std::string name = "estimated";
  double rotation_rate_hz = 10;
  SpinDirection direction = SpinDirection::clockwise;
  double start_azimuth_rad = 3.14159265358979323846;  ///< azimuth of the seam, where turns begin
  double min_range_m = 0;
  double max_range_m = 120;  ///< HDL-64E
  int expected_rings = 64;   ///< preferred if scans differ in their number of rings
  /// Azimuth offsets, one per ring, known to a few columns (find_firing_offsets); empty: not known. Where the
  /// grid leaves whole columns open, those nearest to them are taken.
  std::vector<double> offsets_near_rad = {};
};

struct EstimatedModel {
  LidarModel model;
  BareCloudLayout layout;
  ModelEstimate estimate;
};

/// An uncompensated cloud with a ring per point; the points of a ring by increasing atan2(y, x).
struct RingedCloud {
  std::vector<Eigen::Vector3f> points;
  std::vector<std::int32_t> rings;  ///< one per point; negative: not used
};

/// The clouds that have as many rings as most have, the n-th stored one as ring n.
struct RingedClouds {
  std::vector<RingedCloud> clouds;
  std::vector<std::size_t> numbers;  ///< of each among those given
  std::size_t ring_count = 0;
};
/// Throws InputError naming `source` if no rings are found.
[[nodiscard]] RingedClouds find_rings(const std::vector<std::vector<Eigen::Vector3f>>& clouds,
                                      int expected_rings, const std::string& source);

[[nodiscard]] std::vector<RingPoints> collect_rings(const std::vector<RingedCloud>& clouds,
                                                    std::size_t ring_count);

/// Estimates every laser from a few uncompensated bare clouds of one sensor, stored ring after ring.
/// Elevation and vertical origin follow from a robust line z = z_0 + rho tan(elevation) through each ring,
/// rho = hypot(x, y). The position of the origin along the beam is not observable; it is placed on the spin
/// axis, but for its horizontal offset h perpendicular to the beam.
///
/// Azimuth: with azimuth = hub angle + offset + asin(h / rho), the angle encoder of the hub puts the hub
/// angles on a grid. The spacing of the grid, then h and the phase of each ring, maximise the concentration
/// of the azimuths on it. All lasers fire at the same encoder positions. If these are irregular, they also
/// give the whole columns of the offsets, up to a rotation common to all, which is chosen to centre them on
/// 0.
///
/// Throws InputError naming `source` if no rings are found.
[[nodiscard]] EstimatedModel estimate_model(const std::vector<std::vector<Eigen::Vector3f>>& clouds,
                                            const ModelEstimationOptions& options, const std::string& source);

/// The same from clouds with known rings 0 to `ring_count` - 1; layout.row_of_ring maps them to rows.
[[nodiscard]] EstimatedModel estimate_model_of_rings(const std::vector<RingedCloud>& clouds,
                                                     std::size_t ring_count,
                                                     const ModelEstimationOptions& options,
                                                     const std::string& source);

}  // namespace mapless
