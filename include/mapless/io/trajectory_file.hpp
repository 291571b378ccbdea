#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include <mapless/core/se3.hpp>
#include <mapless/core/time.hpp>
#include <mapless/io/dataset.hpp>
#include <mapless/trajectory/trajectory.hpp>

namespace mapless::inline v1 {

/// Conventions of a trajectory file. Nothing is guessed from its content; the command line prints the values
/// it used.
struct TrajectoryFileOptions {
  PoseDirection direction = PoseDirection::world_from_sensor;
  /// The frame of the file's poses from the sensor frame (camera 0 of KITTI: Tr of calib.txt); identity if
  /// the poses are those of the sensor. The world frame is transformed in the same way: it is the sensor
  /// frame at the first pose of a KITTI file, not the camera frame.
  SE3 T_file_sensor;
  /// For files with one pose per scan (KITTI rows): the instant of each row, one per scan of the recording.
  std::vector<Time> row_times;
  /// Extrapolation allowed before the first and after the last pose; at least 0.
  Duration max_extrapolation;
};

/// Reads a TUM file (t tx ty tz qx qy qz qw per row) or a KITTI file (12 numbers per row), distinguished by
/// the count of numbers. '#' starts a comment. Throws InputError naming file, row and value for text that is
/// not a finite number, a quaternion whose norm is not 1 or a matrix that is not a rotation (both to 1e-3),
/// times that do not increase, and a number of KITTI rows other than that of row_times.
[[nodiscard]] SampledTrajectory read_trajectory_file(const std::filesystem::path& file,
                                                     const TrajectoryFileOptions& options);
/// The same from `text`, the content of `file` (a pipe can be read only once).
[[nodiscard]] SampledTrajectory parse_trajectory(std::string_view text, const std::filesystem::path& file,
                                                 const TrajectoryFileOptions& options);

/// Write T_0v (world from sensor) of every pose: 12 numbers per row (KITTI), or TUM rows. Both throw
/// OutputError.
void write_kitti_poses(const std::filesystem::path& file, const std::vector<TimedPose>& poses);
void write_tum_trajectory(const std::filesystem::path& file, const std::vector<TimedPose>& poses);

/// The same rows as text.
[[nodiscard]] std::string kitti_rows(const std::vector<TimedPose>& poses);
[[nodiscard]] std::string tum_rows(const std::vector<TimedPose>& poses);

/// Reads a CSV table time_s,speed_m_s (norm of the velocity of the lidar) or time_s,x_rad_s,y_rad_s,z_rad_s
/// (its angular velocity in its axes), by increasing time, as measurements without a sigma. Both throw
/// InputError naming file, row, field and value.
[[nodiscard]] std::vector<MotionMeasurement> read_speeds(const std::filesystem::path& file);
[[nodiscard]] std::vector<MotionMeasurement> read_angular_velocities(const std::filesystem::path& file);

/// The motion of one scan along lidar odometry: a row of poses.csv.
struct MotionRow {
  std::size_t scan = 0;             ///< number in the recording
  TimedPose pose;                   ///< at an instant of the scan, by default its start
  std::string_view state = "good";  ///< good, degenerate or lost
  double inlier_ratio = 0;          ///< OdometryUpdate::inlier_ratio
  double mean_robust_weight = 0;    ///< OdometryUpdate::mean_robust_weight
  double constraint_ratio = 0;      ///< Degeneracy::constraint_ratio of the weakest direction
  /// Of the translation during the scan, in the sensor frame [m^2].
  Eigen::Matrix3d motion_covariance_v = Eigen::Matrix3d::Zero();
};

/// Writes scan,time_s,x_m,y_m,z_m,qx,qy,qz,qw (world from sensor), motion_state, inlier_ratio,
/// mean_robust_weight, constraint_ratio, and cov_xx_m2, cov_xy_m2, cov_xz_m2, cov_yy_m2, cov_yz_m2, cov_zz_m2
/// of the translation during the scan in sensor axes. Throws OutputError.
void write_motion_table(const std::filesystem::path& file, const std::vector<MotionRow>& rows);

/// The same as text: the line of names, and the rows.
inline constexpr std::string_view kMotionTableHead =
    "scan,time_s,x_m,y_m,z_m,qx,qy,qz,qw,motion_state,inlier_ratio,mean_robust_weight,"
    "constraint_ratio,cov_xx_m2,cov_xy_m2,cov_xz_m2,cov_yy_m2,cov_yz_m2,cov_zz_m2\n";
[[nodiscard]] std::string motion_table_rows(const std::vector<MotionRow>& rows);

/// The frame whose poses a file holds.
enum class PoseFrame { sensor, camera };
/// The instant within its scan of each row of a file with one pose per scan.
enum class PoseInstant { start, middle, end };

/// Source of the trajectory of a recording, and the conventions of its file.
struct TrajectoryRequest {
  bool stationary = false;     ///< the sensor does not move; `file` is not read
  std::filesystem::path file;  ///< empty: the trajectory of the recording itself
  PoseDirection direction = PoseDirection::world_from_sensor;
  PoseFrame frame = PoseFrame::sensor;
  std::filesystem::path calibration;  ///< for PoseFrame::camera: KITTI's calib.txt or calib_velo_to_cam.txt
  PoseInstant instant = PoseInstant::middle;
  /// Extrapolation at constant velocity allowed beyond the first and last pose of a file; finite and at least
  /// 0. Default: 0 for a file with times; for one row per scan as far as the recording extends beyond the
  /// first and last row (half a scan for PoseInstant::middle).
  std::optional<double> max_extrapolation_s;
};

struct TrajectorySource {
  std::shared_ptr<const Trajectory> trajectory;
  /// Name and value of the conventions used: source, and for a file its direction, frame, instant and
  /// extrapolation.
  std::vector<std::pair<std::string, std::string>> conventions;
};

/// Reads the poses of `request.file` with the conventions of the request. Throws InputError for a file that
/// cannot be used, ParameterError for an extrapolation out of bounds.
[[nodiscard]] SampledTrajectory read_trajectory(const Dataset& dataset, const TrajectoryRequest& request);

/// The trajectory that the request names. Throws as read_trajectory does, and InputError if the recording has
/// none.
[[nodiscard]] TrajectorySource open_trajectory(const Dataset& dataset, const TrajectoryRequest& request);

/// Throws TrajectoryDomainError that names the first of the scans [first, first + count) whose columns the
/// trajectory does not cover, with the times of both; ParameterError for scans beyond the end of the
/// recording.
void require_coverage(const Dataset& dataset, const Trajectory& trajectory, std::size_t first,
                      std::size_t count);

}  // namespace mapless
