#pragma once

#include <string>

#include "benchmark/benchmark_folder.hpp"
#include "reports/json.hpp"

namespace mapless::app {

/// Writes index.html, with everything in it, and the plots beside it. `figures` is benchmark.json: that of
/// paper_figures with the members of the opening. Throws OutputError, InputError for a picture that is gone.
void write_paper_page(const Json& figures, const BenchmarkFolder& folder);

/// The results of the every-scan runs, and the sweep at the published threshold, for a terminal.
[[nodiscard]] std::string paper_text(const Json& figures);

}  // namespace mapless::app
