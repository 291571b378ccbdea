#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include <mapless/evaluation/trajectory_evaluation.hpp>

namespace mapless::app {

/// The report as tables to be read; what is absent has no row. Begins with an empty line.
[[nodiscard]] std::string trajectory_tables(const TrajectoryReport& report);

/// All of it, under the names of the struct's members; what is absent is null.
[[nodiscard]] nlohmann::ordered_json to_json(const TrajectoryReport& report);

}  // namespace mapless::app
