#pragma once

#include <vector>

#include "benchmark/page/page_parts.hpp"

namespace mapless::app {

/// The plots of the paper's evaluation, five per town: precision over recall, total and average, at each
/// noise; after each stage; recall within a range limit; with parts of the method taken away. The published
/// method is solid, the default method dashed.
[[nodiscard]] std::vector<NamedPlot> paper_plots(const Json& figures);

}  // namespace mapless::app
