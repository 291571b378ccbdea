#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include <mapless/lidar/lidar_scan.hpp>
#include <mapless/odometry/parameters.hpp>

namespace mapless {

struct Keypoint {
  Eigen::Vector3d position_v;  ///< at its own instant [m]
  std::int64_t time_ns;        ///< since the start of the scan
};

/// One return (the first) per cube of the sensor frame, by time. Cubes are halved up to twice where they give
/// fewer than `min_keypoints`. Returns nearer than `min_range_m` or beyond `map_radius_m` are not used.
[[nodiscard]] std::vector<Keypoint> select_keypoints(const LidarScan& scan,
                                                     const OdometryParameters& parameters);

}  // namespace mapless
