#pragma once

#include <filesystem>
#include <functional>
#include <optional>

#include "benchmark/benchmark_folder.hpp"
#include "benchmark/plan.hpp"
#include "reports/json.hpp"

namespace mapless::app {

/// Detects and evaluates one run, scan by scan. Memory does not grow with the number of scans, except for
/// their times. Calls `scan_done` after every scan. Pictures, and a drive in 3D, where the job
/// wants them, go to `folder`. Empty where interrupted. Throws InputError for a recording that cannot be
/// used.
///
/// The result has: scans; final and stages (rates); timing (timing_json) and threads, their number;
/// odometry_trouble; for a job of the table also measures (EvaluationReport, sight, delays), and with
/// pictures a list of them (draw_gallery, and one of kind "scan") and view, the file of the drive in 3D.
[[nodiscard]] std::optional<Json> run_job(const Job& job, const std::filesystem::path& recording,
                                          const BenchmarkFolder& folder,
                                          const std::function<void()>& scan_done);

}  // namespace mapless::app
