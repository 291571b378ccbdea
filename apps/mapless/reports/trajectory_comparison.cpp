#include "reports/trajectory_comparison.hpp"

#include <memory>

#include <nlohmann/json.hpp>

#include "terminal/progress.hpp"
#include <mapless/io/files.hpp>
#include <mapless/io/result_folder.hpp>

namespace mapless::app {
namespace {

namespace fs = std::filesystem;

// `mapless detect` uses the recording's own trajectory where there is one: no errors to be found.
bool used_the_recordings_own(const fs::path& result) {
  const fs::path summary = ResultFolder(result).summary();
  if (!fs::is_directory(result) || !fs::exists(summary)) return false;
  const auto json = nlohmann::json::parse(read_whole_file(summary), nullptr, false);
  if (!json.is_object() || !json.contains("trajectory") || !json["trajectory"].is_object()) return false;
  return json["trajectory"].value("source", nlohmann::json()) == "recording";
}

std::shared_ptr<const Trajectory> truth_of(const Dataset& dataset, const fs::path& result,
                                           const TrajectoryRequest& reference) {
  if (!reference.file.empty()) return open_trajectory(dataset, reference).trajectory;
  return used_the_recordings_own(result) ? nullptr : dataset.trajectory();
}

}  // namespace

std::optional<TrajectoryReport> compare_trajectory(const Dataset& dataset, const fs::path& result,
                                                   const TrajectoryComparison& how) {
  TrajectoryRequest estimate;
  estimate.file = fs::is_directory(result) ? ResultFolder(result).trajectory() : result;
  estimate.instant = how.result_instant;
  if (!fs::exists(estimate.file)) return std::nullopt;
  const auto truth = truth_of(dataset, result, how.reference);
  if (!truth) return std::nullopt;
  Progress progress("scans");
  auto report =
      evaluate_trajectory(dataset, *truth, read_trajectory(dataset, estimate),
                          [&progress](std::size_t done, std::size_t of) { progress.update(done, of); });
  progress.clear();
  return report;
}

}  // namespace mapless::app
