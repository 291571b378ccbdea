#pragma once

#include <string>
#include <vector>

#include "benchmark/benchmark_folder.hpp"
#include "benchmark/page/plot.hpp"
#include "reports/json.hpp"

// The page is made of benchmark.json; each part is HTML, empty where there is nothing to show.
namespace mapless::app {

using Cells = std::vector<std::string>;
[[nodiscard]] Cells joined(Cells first, const Cells& second);

/// A rate as "0.853", "-" where absent.
[[nodiscard]] std::string rate_text(const Json& rate);
/// A count with a separator between thousands.
[[nodiscard]] std::string count_text(const Json& count);
/// "town1", followed by the settings in which the runs differ: "town1, noise 0.05 m, seed 2".
[[nodiscard]] std::string run_name(const Json& job);
/// Rows of one part ("table", "sweep", "ablation"), in order.
[[nodiscard]] std::vector<Json> rows_of(const Json& figures, const std::string& part);
/// The rows of the table with true poses, the first sensor, the first noise and the first seed: one per
/// scene.
[[nodiscard]] std::vector<Json> main_rows(const Json& figures);

struct NamedPlot {
  std::string file;  ///< without .png
  Plot plot;
};
/// Precision over recall as the error threshold is swept, one plot per scene.
[[nodiscard]] std::vector<NamedPlot> threshold_plots(const Json& figures);
/// Recall over a range limit, total and average; none without measures.
[[nodiscard]] std::vector<NamedPlot> range_plots(const Json& figures);

[[nodiscard]] std::string results_table(const Json& figures);
[[nodiscard]] std::string stages_table(const Json& figures);
[[nodiscard]] std::string sweep_table(const Json& figures);
[[nodiscard]] std::string ablation_tables(const Json& figures);
[[nodiscard]] std::string timing_table(const Json& figures);
/// By class, range, speed, visible points and object, summed over main_rows.
[[nodiscard]] std::string measure_tables(const Json& figures);
/// The inlined pictures of one kind, from the first `rows` rows that have any.
[[nodiscard]] std::string pictures(const Json& figures, const BenchmarkFolder& folder,
                                   const std::string& kind, std::size_t rows);

}  // namespace mapless::app
