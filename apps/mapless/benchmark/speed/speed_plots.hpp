#pragma once

#include <nlohmann/json.hpp>

#include "benchmark/page/plot.hpp"

namespace mapless::app {

/// Median processor time against the rays of a scan, one point per sensor. Argument: of measure_speed.
[[nodiscard]] Plot time_against_rays(const nlohmann::ordered_json& speed);

/// The median wall time of the pipeline of the first sensor against the threads it had.
[[nodiscard]] Plot time_against_threads(const nlohmann::ordered_json& speed);

}  // namespace mapless::app
