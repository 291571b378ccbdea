#pragma once

#include <optional>
#include <string>

#include <mapless/evaluation/evaluator.hpp>

namespace mapless::app {

/// A rate with three decimals; "-" if absent.
[[nodiscard]] std::string rate_text(const std::optional<double>& rate);

/// The report as text tables, except for its `points`. Tables without truth and rows without points are left
/// out. Begins with an empty line.
[[nodiscard]] std::string report_tables(const EvaluationReport& report);

/// Points seen through a gap, points with only sky behind, delays of starts and stops; empty if the
/// recording has none of them. Begins with an empty line.
[[nodiscard]] std::string hard_case_lines(const SightReport& sight, const std::optional<DelayReport>& delays);

/// The velocity report as lines of text. Begins with an empty line.
[[nodiscard]] std::string velocity_lines(const VelocityReport& report);

}  // namespace mapless::app
