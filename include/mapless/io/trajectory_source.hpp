#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <mapless/io/dataset.hpp>
#include <mapless/io/trajectory_file.hpp>
#include <mapless/trajectory/trajectory.hpp>

namespace mapless::inline v1 {

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
