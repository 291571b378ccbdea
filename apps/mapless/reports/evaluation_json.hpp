#pragma once

#include <nlohmann/json.hpp>

#include <mapless/evaluation/evaluator.hpp>
#include <mapless/evaluation/hard_cases.hpp>

namespace mapless::app {

/// Counts and rates over a set of points; a rate that is absent is null.
[[nodiscard]] nlohmann::ordered_json to_json(const Counts& counts);
/// The same with averages over scans and their N.
[[nodiscard]] nlohmann::ordered_json to_json(const PrecisionRecall& rates);
[[nodiscard]] nlohmann::ordered_json to_json(const Found& found);
/// All of it, under the names of the struct's members. What the recording has no truth for is null.
[[nodiscard]] nlohmann::ordered_json to_json(const EvaluationReport& report);
[[nodiscard]] nlohmann::ordered_json to_json(const VelocityReport& report);
[[nodiscard]] nlohmann::ordered_json to_json(const SightReport& report);
[[nodiscard]] nlohmann::ordered_json to_json(const DelayReport& report);

}  // namespace mapless::app
