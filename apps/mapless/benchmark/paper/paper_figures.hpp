#pragma once

#include <vector>

#include <nlohmann/json.hpp>

#include "benchmark/paper/paper_plan.hpp"

namespace mapless::app {

/// The results of all units (run_unit), in the order of the plan, summed per town, noise, method, treatment
/// and threshold. Counts are sums; averages are means over all scans of all units; times are medians over the
/// units.
///
///     sweep: [{town, range_noise_m, method, treatment, threshold_m, final, stages}]
///     every_scan: [{..., within_range, timing}]
///     pictures: [{file, kind, caption, method, town}]
[[nodiscard]] nlohmann::ordered_json paper_figures(const std::vector<PaperUnit>& units,
                                                   const std::vector<nlohmann::ordered_json>& results);

/// Counts, rates, averages and their N of two sets of scans together. Both are as to_json(PrecisionRecall)
/// writes them.
[[nodiscard]] nlohmann::ordered_json pooled_rates(const nlohmann::ordered_json& a,
                                                  const nlohmann::ordered_json& b);

}  // namespace mapless::app
