#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <utility>
#include <vector>

#include "odometry/registration/mapped_trajectory.hpp"

namespace mapless::test {

/// Scan `k`, of `scan_s` seconds, in a room of 18 x 14 x 10 m, from its middle. `pose_at(t)` is T_v0 at `t`
/// seconds; world frame 0 is that of the room. Its interval is k. Every fifth point is a keypoint.
template <class PoseAt>
UsableScan room_scan(int k, double scan_s, const PoseAt& pose_at) {
  constexpr int kLasers = 40, kColumns = 600;
  const Eigen::Vector3d half_room_m(9, 7, 5);
  std::vector<ScanPoint> points, keypoints;
  for (int column = 0; column < kColumns; ++column) {
    const double part = static_cast<double>(column) / kColumns, azimuth = 2 * std::numbers::pi * part;
    const Eigen::Matrix3d to_room = pose_at(scan_s * (k + part)).inverse().rotation();
    for (int laser = 0; laser < kLasers; ++laser) {
      const double elevation = 0.04 * (laser - kLasers / 2.0 + 0.5);
      const Eigen::Vector3d ray(std::cos(elevation) * std::cos(azimuth),
                                std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
      const Eigen::Array3d in_room = (to_room * ray).array().abs().max(1e-9);
      const double range_m = (half_room_m.array() / in_room).minCoeff();
      points.push_back({(range_m * ray).cast<float>(), static_cast<float>(range_m),
                        static_cast<std::int32_t>(1e9 * scan_s * part), laser, 0});
      if ((laser + 7 * column) % 5 == 0) keypoints.push_back(points.back());
    }
  }
  const Time start = Time::from_seconds(scan_s * k);
  TimeBins bins(keypoints, start, Time());
  return {std::move(points), std::move(bins), {}, start, static_cast<std::size_t>(k)};
}

}  // namespace mapless::test
