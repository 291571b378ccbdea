#pragma once

#include <optional>
#include <string>

#include <mapless/evaluation/evaluation_report.hpp>

namespace mapless::app {

/// Three decimals; "-" where there is none.
[[nodiscard]] std::string rate_text(const std::optional<double>& rate);

/// The report as tables to be read, but for its `points`: what the recording has the truth for, without rows
/// of nothing. Begins with an empty line.
[[nodiscard]] std::string report_tables(const EvaluationReport& report);

}  // namespace mapless::app
