#pragma once

#include <string>

#include <mapless/evaluation/evaluation_report.hpp>

namespace mapless::app {

/// The report as tables to be read, but for its `points`: what the recording has the truth for, without rows
/// of nothing. Begins with an empty line.
[[nodiscard]] std::string report_tables(const EvaluationReport& report);

}  // namespace mapless::app
