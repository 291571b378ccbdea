#pragma once

#include <memory>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include <mapless/core/se3.hpp>
#include <mapless/lidar/lidar_scan.hpp>
#include <mapless/trajectory/trajectory.hpp>

namespace mapless::inline v1 {

/// A scan with the motion of its sensor accounted for (paper step 1): every return in the world frame 0, and
/// the pose of the sensor at the instant of every column, so that each ray can be had from its own origin.
struct CompensatedScan {
  std::shared_ptr<const LidarScan> scan;
  std::vector<TrajectoryState> column_states;  ///< at LidarScan::column_time, one per column
  std::vector<SE3> column_T_0v;                ///< their inverses, sensor to world
  std::vector<Eigen::Vector3d> points_0;       ///< one per return, same order [m]

  /// Where the ray of `laser` starts at the instant of `column`, in the world frame [m].
  [[nodiscard]] Eigen::Vector3d ray_origin_0(int laser, int column) const;
  /// Its unit direction in the world frame.
  [[nodiscard]] Eigen::Vector3d ray_direction_0(int laser, int column) const;
};

/// Moves every return from the sensor frame at its own instant to frame 0. Throws InputError for a scan that
/// somebody else compensated already (see restore_measured_rays), TrajectoryDomainError where the trajectory
/// does not cover it.
[[nodiscard]] CompensatedScan compensate(std::shared_ptr<const LidarScan> scan, const Trajectory& trajectory);

/// A scan's points about an origin near them, so that single precision holds them to a fraction of a
/// millimetre wherever in the world they are.
struct LocalPoints {
  Eigen::Vector3d origin_0;             ///< where the sensor was at the scan's start
  std::vector<Eigen::Vector3f> points;  ///< one per return, minus origin_0 [m]
};

/// `compensate` in single precision: the scan without points_0, and its points.
[[nodiscard]] std::pair<CompensatedScan, LocalPoints> compensate_locally(
    std::shared_ptr<const LidarScan> scan, const Trajectory& trajectory);

/// Undoes another system's motion compensation: from the sensor frame at `scan.compensated_to` back to the
/// sensor frame at each point's own instant, p_v(t) = T_v0(t) T_v0(t_c)^-1 p. Returns a scan with
/// `compensated_to` empty, its cells laid out anew.
[[nodiscard]] LidarScan restore_measured_rays(const LidarScan& scan, const Trajectory& trajectory);

}  // namespace mapless
