#pragma once

#include <vector>

#include "benchmark/paper/paper_plan.hpp"
#include "reports/json.hpp"

namespace mapless::app {

/// The results of all units (run_unit), in the order of the plan, summed per town, noise, method, treatment
/// and threshold. Counts are sums; averages are means over all scans of all units; times are medians over the
/// units.
///
///     sweep: [{town, range_noise_m, method, treatment, threshold_m, final, stages}]
///     every_scan: [{..., within_range, timing}]
///     pictures: [{file, kind, caption, method, town}]
[[nodiscard]] Json paper_figures(const std::vector<PaperUnit>& units, const std::vector<Json>& results);

/// Counts, rates, averages and their N of two sets of scans together. Both are as to_json(PrecisionRecall)
/// writes them.
[[nodiscard]] Json pooled_rates(const Json& a, const Json& b);

}  // namespace mapless::app
