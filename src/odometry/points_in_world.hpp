#pragma once

#include <vector>

#include <Eigen/Core>

#include "odometry/thinning.hpp"
#include <mapless/trajectory/trajectory.hpp>

namespace mapless {

/// Points of a scan in the world frame, every one from the pose at its own instant between two knots.
[[nodiscard]] std::vector<Eigen::Vector3d> points_in_world(const std::vector<ScanPoint>& points,
                                                           Time scan_start, const TrajectoryKnot& k1,
                                                           const TrajectoryKnot& k2);

}  // namespace mapless
