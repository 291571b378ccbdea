#pragma once

#include <filesystem>
#include <optional>

#include <mapless/evaluation/trajectory_evaluation.hpp>
#include <mapless/io/trajectory_file.hpp>

namespace mapless::app {

/// What of `mapless evaluate` is about trajectories.
struct TrajectoryComparison {
  TrajectoryRequest reference;  ///< file empty: the recording's own trajectory is the truth
  PoseInstant result_instant = PoseInstant::start;  ///< of a result of KITTI rows
};

/// The trajectory of a result against the truth. `result` is a folder with trajectory.txt, or a file of TUM
/// or KITTI rows, world from sensor. Absent where the folder has none, there is no truth, or the result was
/// made with that very truth. Throws InputError for files that cannot be used.
[[nodiscard]] std::optional<TrajectoryReport> compare_trajectory(const Dataset& dataset,
                                                                 const std::filesystem::path& result,
                                                                 const TrajectoryComparison& how);

}  // namespace mapless::app
