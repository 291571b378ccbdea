#include <algorithm>
#include <array>
#include <optional>

#include <fmt/format.h>

#include "io/self_check/motion_check.hpp"
#include "io/self_check/pose_check.hpp"
#include "io/self_check/scan_checks.hpp"
#include "io/self_check/time_check.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/dataset.hpp>

namespace mapless::inline v1 {
namespace {

// Scans that are looked at: spread over the recording, one per 200 scans, so that they cost little beside a
// run.
constexpr std::size_t kFewestPlaces = 3, kMostPlaces = 12, kScansPerPlace = 200;
// Small mistakes of poses show at several places together.
constexpr std::size_t kMorePlaces = 2;

std::vector<std::size_t> places(std::size_t first, std::size_t count) {
  const std::size_t n = std::min(count, std::clamp(count / kScansPerPlace, kFewestPlaces, kMostPlaces));
  std::vector<std::size_t> out;
  for (std::size_t i = 0; i < n; ++i) out.push_back(first + (n == 1 ? 0 : i * (count - 1) / (n - 1)));
  return out;
}

std::optional<LidarScan> readable(const Dataset& dataset, std::size_t k) try {
  return dataset.read(k);
} catch (const InputError&) {  // the run says so when it reaches the scan
  return std::nullopt;
}

// Whether there are points at all.
ScanFinding check_counts(const std::vector<std::size_t>& returns) {
  ScanFinding found;
  if (returns.empty()) {
    found.measured = "not checked: no scan can be read";
    return found;
  }
  const std::size_t most = *std::max_element(returns.begin(), returns.end());
  found.measured = fmt::format("up to {} usable points a scan", most);
  found.trust = most < kFewestSamples ? Trust::doubtful : Trust::right;
  if (found.trust == Trust::right) return found;
  found.problem = most == 0 ? "no scan looked at has a usable point"
                            : fmt::format("no scan looked at has more than {} usable points", most);
  found.remedy = "give scans with points";
  return found;
}

// The beams were estimated from clouds whose motion compensation was taken back: how far from them the points
// then lie tells whether the poses follow the motion within a turn. Measured, RMS: a real car .004 m,
// simulated ones below .001 m; with one pose a turn, in flight .016, carried by hand .024 m (IoU .10).
constexpr double kRestored_m = 0.01;
void hold_against_estimate(const Dataset& dataset, CheckResult& beams) {
  const auto estimate = dataset.model_estimate();
  if (!estimate) return;
  const double residual_m = estimate->elevation_residual_m;
  beams.measured =
      fmt::format("taken back to the instants of their firings, the points lie {:.1f} mm off the beams (RMS)",
                  1e3 * residual_m);
  beams.trust = residual_m > kRestored_m ? Trust::doubtful : Trust::right;
  if (beams.trust == Trust::right) return;
  beams.where = dataset.scan_file(0).string();
  beams.problem = beams.measured + ": the poses do not follow the motion within a turn";
  beams.remedy = "give poses at a higher rate (--trajectory), or clouds that are not motion-compensated";
}

}  // namespace

std::string_view name_of(Trust trust) {
  constexpr std::array<std::string_view, 4> kNames = {"not checked", "right", "doubtful", "wrong"};
  return kNames.at(static_cast<std::size_t>(trust));
}

std::vector<CheckResult> check_recording(const Dataset& dataset,
                                         const std::shared_ptr<const Trajectory>& given, std::size_t first,
                                         std::size_t count) {
  ScanChecks scans;
  std::vector<std::size_t> returns;
  bool compensated = false;
  const std::vector<std::size_t> looked_at = places(first, count);
  for (const std::size_t k : looked_at) {
    const auto scan = readable(dataset, k);
    if (!scan) continue;
    scans.add(*scan, k, given.get());
    returns.push_back(scan->returns.size());
    compensated = compensated || scan->compensated_to.has_value();
  }
  std::vector<CheckResult> results = scans.results(dataset);
  if (compensated) {
    for (CheckResult& result : results) {
      if (result.name == "beams") hold_against_estimate(dataset, result);
    }
  }
  Findings counts("points"), scan_times("scan times");
  counts.add(check_counts(returns), first);
  results.push_back(counts.result(dataset));
  scan_times.add(check_scan_times(dataset, first, count), first);
  results.push_back(scan_times.result(dataset));
  CheckResult poses = check_poses(dataset, given, first, count, looked_at);
  // What is said of poses that are far off is said once.
  const auto nearly_right = poses.trust == Trust::right ? given : nullptr;
  for (CheckResult& result :
       check_motion(dataset, nearly_right, first, count, looked_at.size() + kMorePlaces))
    results.push_back(std::move(result));
  results.push_back(std::move(poses));
  return results;
}

void require_trusted(const std::vector<CheckResult>& results) {
  for (const CheckResult& r : results) {
    if (r.trust == Trust::wrong) throw InputError({r.where, r.name, "", r.problem, r.remedy});
  }
}

}  // namespace mapless
