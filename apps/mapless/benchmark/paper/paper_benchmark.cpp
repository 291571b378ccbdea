#include "benchmark/paper/paper_benchmark.hpp"

#include <optional>
#include <vector>

#include <fmt/format.h>
#include <tbb/global_control.h>

#include "benchmark/benchmark_folder.hpp"
#include "benchmark/paper/paper_figures.hpp"
#include "benchmark/paper/paper_page.hpp"
#include "benchmark/paper/paper_unit_run.hpp"
#include "benchmark/work_pool.hpp"
#include "reports/json.hpp"
#include "reports/json_text.hpp"
#include "terminal/interrupt.hpp"
#include "terminal/stderr.hpp"
#include <mapless/io/files.hpp>

namespace mapless::app {
namespace {

std::vector<std::optional<Json>> finished_units(const std::vector<PaperUnit>& units,
                                                const BenchmarkFolder& folder) {
  std::vector<std::optional<Json>> out;
  for (const PaperUnit& unit : units) out.push_back(folder.finished(unit.stem(), unit.json()));
  return out;
}

std::size_t number_of(const std::vector<std::optional<Json>>& finished) {
  std::size_t number = 0;
  for (const auto& result : finished) number += result ? 1 : 0;
  return number;
}

/// False where interrupted.
bool run_missing_units(const std::vector<PaperUnit>& units, const std::vector<std::optional<Json>>& finished,
                       const BenchmarkFolder& folder, std::size_t threads) {
  std::vector<LongTask> tasks;
  std::size_t steps = 0;
  for (std::size_t i = 0; i < units.size(); ++i) {
    if (finished[i]) continue;
    steps += steps_of(units[i]);
    tasks.emplace_back([&folder, &unit = units[i]](const auto& step_done) {
      const auto result = run_unit(unit, folder.pictures(), step_done);
      if (result) folder.finish(unit.stem(), unit.json(), *result);
      return result.has_value();
    });
  }
  return work_side_by_side(tasks, threads, steps, "scans");
}

}  // namespace

int benchmark_paper(const PaperOptions& options, const std::string& output, std::size_t threads,
                    const Json& about) {
  const std::vector<PaperUnit> units = make_paper_plan(options);
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
  const BenchmarkFolder folder(output, build_digest());
  folder.open();
  auto finished = finished_units(units, folder);
  say("mapless: {} parts, {} of them finished before\n", units.size(), number_of(finished));

  const InterruptGuard interrupt;
  if (!run_missing_units(units, finished, folder, threads)) {
    say("mapless: interrupted; {} of {} parts are finished and kept, the same command goes on from there\n",
        number_of(finished_units(units, folder)), units.size());
    return InterruptGuard::exit_code();
  }
  finished = finished_units(units, folder);
  std::vector<Json> results;
  results.reserve(finished.size());
  for (const auto& result : finished) results.push_back(result.value());
  Json all = about;
  all["quick"] = options.quick;
  all["seed"] = options.seeds.front();
  all["duration_s"] = units.front().recording.duration_s;
  all["threads"] = threads;
  all.update(paper_figures(units, results));
  write_paper_page(all, folder);
  write_file_atomically(folder.figures(), json_text(all));
  fmt::print("{}page: {}\nfigures: {}\n", paper_text(all), folder.page().string(), folder.figures().string());
  return 0;
}

}  // namespace mapless::app
