#pragma once

#include <filesystem>
#include <functional>
#include <optional>

#include "benchmark/plan.hpp"
#include "reports/json.hpp"

namespace mapless::app {

/// Detects and evaluates one run, scan by scan. Memory does not grow with the number of scans, except for
/// their times. Calls `scan_done` after every scan. Pictures, where the job wants them, go to
/// `pictures`. Empty where interrupted. Throws InputError for a recording that cannot be used.
///
/// The result has: scans; final and stages (rates); timing (timing_json) and threads, their number;
/// odometry_trouble; for a job of the table also measures (EvaluationReport, sight, delays), and with
/// pictures a list of them (draw_gallery, and one of kind "scan").
[[nodiscard]] std::optional<Json> run_job(const Job& job, const std::filesystem::path& recording,
                                          const std::filesystem::path& pictures,
                                          const std::function<void()>& scan_done);

}  // namespace mapless::app
