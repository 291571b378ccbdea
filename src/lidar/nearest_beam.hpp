#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include <mapless/lidar/lidar_model.hpp>

namespace mapless::inline v1 {

/// Which laser measured each point, for clouds that do not say.
struct BeamAssignment {
  std::vector<std::int32_t> lasers;  ///< 0 for points that are no measurement
  /// Median angle between a usable point and the cone of its laser, over the median step in elevation between
  /// lasers: 0.25 for points that have nothing to do with the lasers. 0 where no point is usable.
  double misfit = 0;
};

/// The laser whose cone passes nearest to the point.
[[nodiscard]] BeamAssignment nearest_beams(const std::vector<Eigen::Vector3f>& points,
                                           const LidarModel& model);

/// How well lasers that are known fit the points.
[[nodiscard]] double beam_misfit(const std::vector<Eigen::Vector3f>& points,
                                 const std::vector<std::int32_t>& lasers, const LidarModel& model);

}  // namespace mapless
