#pragma once

#include <filesystem>
#include <optional>

#include <mapless/evaluation/trajectory_evaluation.hpp>
#include <mapless/io/trajectory_file.hpp>

namespace mapless::app {

/// Options of `mapless evaluate` that concern trajectories.
struct TrajectoryComparison {
  TrajectoryRequest reference;  ///< empty file: the recording's own trajectory is the reference
  PoseInstant result_instant =
      PoseInstant::start;  ///< instant in a scan of each pose, for a result of KITTI rows
};

/// Compares the trajectory of a result with the reference. `result` is a folder with trajectory.txt, or a
/// file of TUM or KITTI rows, world from sensor. Absent if the folder has no trajectory, if there is no
/// reference, or if the result was made with the reference itself. Throws InputError for files that cannot be
/// used.
[[nodiscard]] std::optional<TrajectoryReport> compare_trajectory(const Dataset& dataset,
                                                                 const std::filesystem::path& result,
                                                                 const TrajectoryComparison& how);

}  // namespace mapless::app
