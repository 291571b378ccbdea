#pragma once

#include "benchmark/page/plot.hpp"
#include "reports/json.hpp"

namespace mapless::app {

/// Median processor time against the rays of a scan, one point per sensor. Argument: of measure_speed.
[[nodiscard]] Plot time_against_rays(const Json& speed);

/// The median wall time of the pipeline of the first sensor against the threads it had.
[[nodiscard]] Plot time_against_threads(const Json& speed);

}  // namespace mapless::app
