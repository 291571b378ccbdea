#pragma once

#include <vector>

#include <Eigen/Core>

#include "odometry/keypoints/thinning.hpp"
#include "odometry/map/map_point.hpp"
#include <mapless/trajectory/trajectory.hpp>

namespace mapless::inline v1 {

/// Transforms the points of a scan to the world frame, each with the pose at its own instant between knots
/// `k1` and `k2`.
[[nodiscard]] std::vector<MapPoint> points_in_world(const std::vector<ScanPoint>& points, Time scan_start,
                                                    const TrajectoryKnot& k1, const TrajectoryKnot& k2);

}  // namespace mapless
