#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "benchmark/benchmark_folder.hpp"

namespace mapless::app {

/// Writes index.html, which contains all its pictures, and the plots beside it. `figures` is benchmark.json;
/// the pictures its rows name are in `folder`. Throws OutputError; InputError if a picture is missing.
void write_page(const nlohmann::ordered_json& figures, const BenchmarkFolder& folder);

/// The table of results for a terminal.
[[nodiscard]] std::string results_text(const nlohmann::ordered_json& figures);

}  // namespace mapless::app
