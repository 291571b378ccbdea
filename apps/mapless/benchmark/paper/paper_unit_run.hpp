#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>

#include "benchmark/paper/paper_plan.hpp"
#include "reports/json.hpp"

namespace mapless::app {

/// Number of calls of `step_done` by run_unit: one per scan evaluated.
[[nodiscard]] std::size_t steps_of(const PaperUnit& unit);

/// Simulates the scans of the unit and runs all its detectors over them. Memory: the scans of a sweep (about
/// 50, 5 MB each) and one detector; where every scan is evaluated, two detectors and the scan. Empty where
/// interrupted. Pictures, where the unit wants them, go to the folder `pictures`.
///
/// The result: "runs", a list with method, treatment and threshold_m of each run, its rates after each stage
/// (stages) and of the final labels (final); for the part every_scan also within_range and timing; and
/// "pictures", a list with the method of each added.
[[nodiscard]] std::optional<Json> run_unit(const PaperUnit& unit, const std::filesystem::path& pictures,
                                           const std::function<void()>& step_done);

}  // namespace mapless::app
