#pragma once

#include <memory>
#include <string>
#include <vector>

#include "run/detection_run.hpp"
#include <mapless/io/dataset.hpp>
#include <mapless/trajectory/trajectory.hpp>

namespace mapless::app {

/// Holds the scans against what is said about them, along the poses where there are any (check_recording).
/// Throws InputError where they contradict; says doubts on stderr, and returns their lines.
[[nodiscard]] std::vector<std::string> said_doubts(const Dataset& dataset,
                                                   const std::shared_ptr<const Trajectory>& given,
                                                   ScanSelection selection);

}  // namespace mapless::app
