#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <mapless/core/se3.hpp>
#include <mapless/core/time.hpp>
#include <mapless/io/dataset.hpp>
#include <mapless/trajectory/trajectory.hpp>

namespace mapless::inline v1 {

/// How the rows of a trajectory file are to be read. Nothing here is guessed: what is not stated is the
/// default, and the command line prints what it used.
struct TrajectoryFileOptions {
  PoseDirection direction = PoseDirection::world_from_sensor;
  /// Transform from the sensor to the frame the file's poses are of (KITTI's camera 0: Tr of calib.txt);
  /// identity where they are of the sensor itself. The world is turned the same way, so that it stays what
  /// the sensor frame was at the first pose of a KITTI file.
  SE3 T_file_sensor;
  /// For files of one pose per scan (KITTI rows): the instant of each row, one per scan of the recording.
  std::vector<Time> row_times;
  /// How far before the first and after the last pose the trajectory may be asked.
  Duration max_extrapolation;
};

/// Reads a TUM file (t tx ty tz qx qy qz qw a row) or a KITTI file (12 numbers a row), told apart by the
/// count of numbers. '#' starts a comment. Throws InputError naming file, row and value: not numbers, not
/// finite, quaternion of norm 0 or matrix not a rotation (both to 1e-3), times not increasing, fewer or more
/// KITTI rows than row_times.
[[nodiscard]] SampledTrajectory read_trajectory_file(const std::filesystem::path& file,
                                                     const TrajectoryFileOptions& options);
/// The same of the text of `file`, which a pipe gives but once.
[[nodiscard]] SampledTrajectory parse_trajectory(std::string_view text, const std::filesystem::path& file,
                                                 const TrajectoryFileOptions& options);

/// Rows of T_0v (world from sensor), 12 numbers each, and TUM rows, at the given times.
void write_kitti_poses(const std::filesystem::path& file, const std::vector<TimedPose>& poses);
void write_tum_trajectory(const std::filesystem::path& file, const std::vector<TimedPose>& poses);

/// The frame the poses of a file are of.
enum class PoseFrame { sensor, camera };
/// The instant of its scan each row of a file with one pose per scan is of.
enum class PoseInstant { start, middle, end };

/// Where the trajectory of a recording is to come from, and how its file is to be read.
struct TrajectoryRequest {
  bool stationary = false;
  std::filesystem::path file;  ///< empty: the recording's own
  PoseDirection direction = PoseDirection::world_from_sensor;
  PoseFrame frame = PoseFrame::sensor;
  std::filesystem::path calibration;  ///< for PoseFrame::camera: KITTI's calib.txt or calib_velo_to_cam.txt
  PoseInstant instant = PoseInstant::middle;
  /// How far beyond its first and last pose the trajectory of a file may be asked, at constant velocity. Not
  /// given: 0 for a file with times; as far as the recording reaches beyond the first and last row where
  /// there is one row per scan (half a scan for PoseInstant::middle).
  std::optional<double> max_extrapolation_s;
};

struct TrajectorySource {
  std::shared_ptr<const Trajectory> trajectory;
  /// What was used, in order: source, and for a file its direction, frame, instant and extrapolation.
  std::vector<std::pair<std::string, std::string>> conventions;
};

/// The poses of `request.file`, read as the request says. Throws InputError where it cannot be used.
[[nodiscard]] SampledTrajectory read_trajectory(const Dataset& dataset, const TrajectoryRequest& request);

/// Throws InputError where there is no trajectory, or its file cannot be used.
[[nodiscard]] TrajectorySource open_trajectory(const Dataset& dataset, const TrajectoryRequest& request);

/// Throws TrajectoryDomainError naming the first of the scans [first, first + count) that the trajectory does
/// not cover to its last column, with the times of both.
void require_coverage(const Dataset& dataset, const Trajectory& trajectory, std::size_t first,
                      std::size_t count);

}  // namespace mapless
