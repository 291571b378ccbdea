#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include <mapless/lidar/lidar_model.hpp>

namespace mapless::inline v1 {

/// Estimated laser of each point, for clouds without rings.
struct BeamAssignment {
  std::vector<std::int32_t> lasers;  ///< row; 0 for unusable points
  /// Median angle between a usable point and the cone of its laser, divided by the median step in elevation
  /// between lasers; of some 4,000 of the points. Random points give 0.25; 0 without a usable point.
  double misfit = 0;
};

/// For each point the laser whose cone passes nearest to it.
[[nodiscard]] BeamAssignment nearest_beams(const std::vector<Eigen::Vector3f>& points,
                                           const LidarModel& model);

/// The misfit (see above) of points with known lasers.
[[nodiscard]] double beam_misfit(const std::vector<Eigen::Vector3f>& points,
                                 const std::vector<std::int32_t>& lasers, const LidarModel& model);

}  // namespace mapless
