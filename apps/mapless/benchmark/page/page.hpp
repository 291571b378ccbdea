#pragma once

#include <string>

#include "benchmark/benchmark_folder.hpp"
#include "reports/json.hpp"

namespace mapless::app {

/// Writes index.html, which contains all its pictures, and the plots beside it. `figures` is benchmark.json;
/// the pictures its rows name are in `folder`. Throws OutputError; InputError if a picture is missing.
void write_page(const Json& figures, const BenchmarkFolder& folder);

/// The table of results for a terminal.
[[nodiscard]] std::string results_text(const Json& figures);

}  // namespace mapless::app
