#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "reports/json.hpp"
#include "run/run_summary.hpp"
#include <mapless/io/dataset.hpp>
#include <mapless/io/result_folder.hpp>

namespace mapless::app {

/// A result in the output folder that a run goes on with (--resume).
struct EarlierRun {
  std::size_t finished = 0;         ///< scans with labels and stages, counted from the first without a gap
  bool complete = false;            ///< all scans, and the summary
  std::vector<std::string> doubts;  ///< RunSummary::doubts
};

/// The earlier run; nothing where the folder is empty or no scan was finished. `now` and `configuration`: the
/// summary and the content of config.yaml of the run that would go on. Throws OutputError where the folder
/// holds something else, ParameterError that names what differs: version, recording, poses, an option or a
/// parameter.
[[nodiscard]] std::optional<EarlierRun> earlier_run(const ResultFolder& result, const RunSummary& now,
                                                    const std::string& configuration);

/// The same of a run of `mapless odometry`, whose summary would be `now`. A scan is finished where its row is
/// in poses.csv.
[[nodiscard]] std::optional<EarlierRun> earlier_odometry(const ResultFolder& result, const Json& now,
                                                         const std::string& configuration);

/// Digest of the start times and file sizes of scans [first, first + count), of the poses at these times and
/// of the measurements given to the odometry: distinguishes one recording and one trajectory from another
/// without reading the points.
[[nodiscard]] std::string recording_digest(const Dataset& dataset, const Trajectory* given,
                                           std::span<const MotionMeasurement> measured, std::size_t first,
                                           std::size_t count);

}  // namespace mapless::app
