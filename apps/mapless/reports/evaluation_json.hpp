#pragma once

#include "reports/json.hpp"
#include <mapless/evaluation/evaluator.hpp>

namespace mapless::app {

/// Counts and rates over a set of points; a rate that is absent is null.
[[nodiscard]] Json to_json(const Counts& counts);
/// Total counts and rates, the average rates over scans, and the number of scans in each average.
[[nodiscard]] Json to_json(const PrecisionRecall& rates);
[[nodiscard]] Json to_json(const Found& found);
/// Every member of the report under its own name. A member is null where the recording has no truth for it.
[[nodiscard]] Json to_json(const EvaluationReport& report);
[[nodiscard]] Json to_json(const VelocityReport& report);
[[nodiscard]] Json to_json(const SightReport& report);
[[nodiscard]] Json to_json(const DelayReport& report);

}  // namespace mapless::app
