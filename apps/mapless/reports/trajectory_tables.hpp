#pragma once

#include <string>

#include "reports/json.hpp"
#include <mapless/evaluation/trajectory_evaluation.hpp>

namespace mapless::app {

/// The report as text tables; absent members have no row. Begins with an empty line.
[[nodiscard]] std::string trajectory_tables(const TrajectoryReport& report);

/// Every member of the report under its own name; an absent one is null.
[[nodiscard]] Json to_json(const TrajectoryReport& report);

}  // namespace mapless::app
