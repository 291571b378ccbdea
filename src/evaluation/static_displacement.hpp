#pragma once

#include <cstddef>
#include <vector>

#include <mapless/lidar/lidar_scan.hpp>
#include <mapless/trajectory/trajectory.hpp>

namespace mapless::inline v1 {

/// True and estimated pose of the sensor at every column of a scan.
struct ScanPoses {
  std::vector<SE3> T_0v_true;
  std::vector<SE3> T_v0_true;
  std::vector<SE3> T_0v_estimated;
};

/// Throws TrajectoryDomainError if one of the trajectories does not cover the scan.
[[nodiscard]] ScanPoses poses_of(const LidarScan& scan, const Trajectory& truth, const Trajectory& estimate);

/// Apparent displacement [m] of static points between two scans that the error of the estimated trajectory
/// causes. It decides whether static points look dynamic when the two scans are compared; sensor noise does
/// not enter. For every `stride`-th return p of `query`, measured at t_q and taken as static:
///
///     | E_0v(t_q) p - E_0v(t_r) T_v0(t_r) T_0v(t_q) p |
/// with the estimated trajectory E and the true trajectory T; t_r is the instant at which the same laser
/// points towards p in the reference scan (nearest column; the first or last one if p passes the seam).
/// Throws ParameterError for a stride of 0.
[[nodiscard]] std::vector<double> static_displacements(const LidarScan& query, const ScanPoses& at_query,
                                                       const ScanPoses& at_reference, std::size_t stride);

}  // namespace mapless
