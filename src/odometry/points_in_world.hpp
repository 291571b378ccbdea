#pragma once

#include <vector>

#include <Eigen/Core>

#include <mapless/lidar/lidar_scan.hpp>
#include <mapless/odometry/parameters.hpp>
#include <mapless/trajectory/trajectory.hpp>

namespace mapless {

/// The usable returns of a scan in the world frame, every one from the pose at its own instant between two
/// knots. Neighbours in the scan come far apart, so that no ring fills the cubes of a map before the others.
[[nodiscard]] std::vector<Eigen::Vector3d> points_in_world(const LidarScan& scan, const TrajectoryKnot& k1,
                                                           const TrajectoryKnot& k2,
                                                           const OdometryParameters& parameters);

}  // namespace mapless
