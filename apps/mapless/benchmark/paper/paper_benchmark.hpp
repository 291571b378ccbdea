#pragma once

#include <cstddef>
#include <string>

#include "benchmark/paper/paper_plan.hpp"
#include "reports/json.hpp"

namespace mapless::app {

/// Runs all units that are not finished in the folder `output`, and writes page and figures. Returns the exit
/// code. `about`: members for benchmark.json (date, processor, version). Throws ParameterError, OutputError.
int benchmark_paper(const PaperOptions& options, const std::string& output, std::size_t threads,
                    const Json& about);

}  // namespace mapless::app
