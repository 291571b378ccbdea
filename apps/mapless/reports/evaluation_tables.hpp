#pragma once

#include <optional>
#include <string>

#include <mapless/evaluation/evaluator.hpp>
#include <mapless/evaluation/hard_cases.hpp>

namespace mapless::app {

/// Three decimals; "-" where there is none.
[[nodiscard]] std::string rate_text(const std::optional<double>& rate);

/// The report as tables to be read, but for its `points`: what the recording has the truth for, without rows
/// of nothing. Begins with an empty line.
[[nodiscard]] std::string report_tables(const EvaluationReport& report);

/// Points seen through a gap, points with only sky behind, delays of starts and stops; empty where the
/// recording has none of them. Begins with an empty line.
[[nodiscard]] std::string hard_case_lines(const SightReport& sight, const std::optional<DelayReport>& delays);

/// The same of the velocities. Begins with an empty line.
[[nodiscard]] std::string velocity_lines(const VelocityReport& report);

}  // namespace mapless::app
