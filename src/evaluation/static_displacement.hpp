#pragma once

#include <cstddef>
#include <vector>

#include <mapless/lidar/lidar_scan.hpp>
#include <mapless/trajectory/trajectory.hpp>

namespace mapless::inline v1 {

/// Where the sensor was at every column of a scan, in truth and by an estimate.
struct ScanPoses {
  std::vector<SE3> T_0v_true;
  std::vector<SE3> T_v0_true;
  std::vector<SE3> T_0v_estimated;
};

/// Throws TrajectoryDomainError where one of them does not cover the scan.
[[nodiscard]] ScanPoses poses_of(const LidarScan& scan, const Trajectory& truth, const Trajectory& estimate);

/// How far the estimated trajectory alone moves a point that stands still from one scan to another: the
/// figure that decides whether static points look dynamic to a comparison of the two. For every `stride`-th
/// return p of `query`, measured at t_q and thought of as standing still [m]:
///
///     | E_0v(t_q) p - E_0v(t_r) T_v0(t_r) T_0v(t_q) p |
///
/// E the estimated and T the true trajectory; t_r is the instant at which the same laser points towards p in
/// the reference scan (the nearest column; the first or last one where p passes the seam). Sensor noise has
/// no part in it.
[[nodiscard]] std::vector<double> static_displacements(const LidarScan& query, const ScanPoses& at_query,
                                                       const ScanPoses& at_reference, std::size_t stride);

}  // namespace mapless
