#pragma once

/// @file
/// Room geometry: points in space. In go a LidarScan and a Trajectory; out come points and rays in the world
/// frame with the motion of the sensor during the scan accounted for, normals, and nearest neighbours. Every
/// result is computed once per scan and not changed afterwards.

#include <memory>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include <mapless/core/se3.hpp>
#include <mapless/lidar/lidar_scan.hpp>
#include <mapless/trajectory/trajectory.hpp>

namespace mapless::inline v1 {

/// A motion-compensated scan (paper, section III-A, step 1): every return in the world frame 0, and the pose
/// of the sensor at the instant of every column, from which the origin and direction of every ray follow.
struct CompensatedScan {
  std::shared_ptr<const LidarScan> scan;
  std::vector<TrajectoryState> column_states;  ///< at LidarScan::column_time, one per column
  std::vector<SE3> column_T_0v;                ///< world from sensor: the inverses of their T_v0
  std::vector<Eigen::Vector3d> points_0;       ///< one per return, in the order of scan->returns [m]

  /// Origin of the ray of `laser` at the instant of `column`, in the world frame [m].
  [[nodiscard]] Eigen::Vector3d ray_origin_0(int laser, int column) const;
  /// Unit direction of that ray in the world frame.
  [[nodiscard]] Eigen::Vector3d ray_direction_0(int laser, int column) const;
};

/// Transforms every return from the sensor frame at its own instant to frame 0 (paper Eq. 1). Throws
/// ParameterError for a null scan, InputError for a scan that is already motion-compensated (see
/// restore_measured_rays), TrajectoryDomainError if the trajectory does not cover the scan.
[[nodiscard]] CompensatedScan compensate(std::shared_ptr<const LidarScan> scan, const Trajectory& trajectory);

/// The points of a scan relative to an origin near them, in the axes of frame 0. Single precision resolves
/// them to a fraction of a millimetre at any distance from the world's origin.
struct LocalPoints {
  Eigen::Vector3d origin_0;             ///< position of the sensor at the start of the scan [m]
  std::vector<Eigen::Vector3f> points;  ///< one per return: position in frame 0 minus origin_0 [m]
};

/// compensate() in single precision: a scan with empty points_0, and its points. Throws as compensate() does.
[[nodiscard]] std::pair<CompensatedScan, LocalPoints> compensate_locally(
    std::shared_ptr<const LidarScan> scan, const Trajectory& trajectory);

/// Undoes the motion compensation by another system: transforms every point from the sensor frame at
/// t_c = scan.compensated_to to the sensor frame at its own instant t, p_v(t) = T_v0(t) T_v0(t_c)^-1 p.
/// Returns a scan whose compensated_to is empty and whose cells are assigned anew. Throws InputError for a
/// scan that is not compensated, TrajectoryDomainError if the trajectory does not cover the scan and t_c.
[[nodiscard]] LidarScan restore_measured_rays(const LidarScan& scan, const Trajectory& trajectory);

}  // namespace mapless
