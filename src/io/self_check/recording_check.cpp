#include <algorithm>
#include <array>
#include <optional>

#include <fmt/format.h>

#include "io/self_check/motion_check.hpp"
#include "io/self_check/pose_check.hpp"
#include "lidar/self_check/scan_checks.hpp"
#include "lidar/self_check/time_check.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/dataset.hpp>

namespace mapless::inline v1 {
namespace {

// Scans that are looked at: spread over the recording, one per 200 scans, so that they cost little beside a
// run.
constexpr std::size_t kFewestPlaces = 3, kMostPlaces = 12, kScansPerPlace = 200;
// Small mistakes of poses show at several places together.
constexpr std::size_t kMorePlaces = 2;
// Two scans overlap where the later begins this share of a turn before the end of the earlier.
constexpr double kOverlap = 0.2;

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

// Distance between the starts of scans against the duration of a turn.
ScanFinding check_scan_times(const Dataset& dataset, std::size_t first, std::size_t count) {
  ScanFinding found = check_rate(*dataset.model());
  if (found.trust != Trust::right) return found;
  if (count < 2) {
    found.measured = "not checked: one scan";
    return found;
  }
  std::vector<double> periods;
  std::size_t overlapping = 0, first_overlapping = 0;
  const double turn_s = (dataset.scan_end(first) - dataset.scan_start(first)).seconds();
  for (std::size_t k = first + 1; k < first + count; ++k) {
    periods.push_back((dataset.scan_start(k) - dataset.scan_start(k - 1)).seconds());
    if (periods.back() > (1 - kOverlap) * turn_s) continue;
    if (overlapping++ == 0) first_overlapping = k;
  }
  const double period_s = median(std::move(periods));
  found.size = turn_s > 0 ? std::max(0.0, 1 - period_s / turn_s) : 0;
  found.measured = fmt::format("the scans begin {:.4f} s apart, a turn takes {:.4f} s", period_s, turn_s);
  found.trust = Trust::right;
  if (overlapping == 0) return found;
  found.trust = period_s < (1 - kOverlap) * turn_s ? Trust::wrong : Trust::doubtful;
  found.problem = fmt::format(
      "{} of {} scans begin before the scan before them ends, scan {} the first: scans begin "
      "{:.4f} s apart, a turn takes {:.4f} s",
      overlapping, count, first_overlapping, period_s, turn_s);
  found.remedy = "correct the times of the scans, or the rate of the sensor";
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

std::vector<CheckResult> check_recording(const Dataset& dataset,
                                         const std::shared_ptr<const Trajectory>& given, std::size_t first,
                                         std::size_t count) {
  const auto file_of = [&](std::size_t k) { return dataset.scan_file(k).string(); };
  const GivenPoses poses_given = given ? GivenPoses([&](Time t) { return given->at(t).T_v0; }) : GivenPoses();
  ScanChecks scans;
  std::vector<std::size_t> returns;
  bool compensated = false;
  const std::vector<std::size_t> looked_at = places(first, count);
  for (const std::size_t k : looked_at) {
    const auto scan = readable(dataset, k);
    if (!scan) continue;
    scans.add(*scan, k, poses_given);
    returns.push_back(scan->returns.size());
    compensated = compensated || scan->compensated_to.has_value();
  }
  std::vector<CheckResult> results = scans.results(file_of);
  if (compensated) {
    for (CheckResult& result : results) {
      if (result.name == "beams") hold_against_estimate(dataset, result);
    }
  }
  Findings counts("points"), scan_times("scan times");
  counts.add(check_counts(returns), first);
  results.push_back(counts.result(file_of));
  scan_times.add(check_scan_times(dataset, first, count), first);
  results.push_back(scan_times.result(file_of));
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
