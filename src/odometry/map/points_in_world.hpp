#pragma once

#include <vector>

#include <Eigen/Core>

#include "odometry/keypoints/thinning.hpp"
#include "odometry/map/plane_map.hpp"
#include <mapless/trajectory/trajectory.hpp>

namespace mapless::inline v1 {

/// Points of a scan in the world frame, every one from the pose at its own instant between two knots. Their
/// lines are `first_line` and the laser's number.
[[nodiscard]] std::vector<MapPoint> points_in_world(const std::vector<ScanPoint>& points, Time scan_start,
                                                    const TrajectoryKnot& k1, const TrajectoryKnot& k2,
                                                    unsigned first_line = 0);

}  // namespace mapless
