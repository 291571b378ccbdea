#include <vector>

#include <fmt/format.h>

#include <mapless/pipeline/online_detector.hpp>

namespace mapless::inline v1 {
namespace {

bool is_extrapolated(ScanOutcome outcome) {
  return outcome != ScanOutcome::registered && outcome != ScanOutcome::first;
}

}  // namespace

void OdometryReport::add(const LidarScan& scan, const OdometryUpdate& update) {
  const ScanOutcome outcome = update.outcome;
  const bool registered = outcome == ScanOutcome::registered;
  if (is_extrapolated(outcome) && extrapolated++ == 0) first_extrapolated = scans;
  few_points += outcome == ScanOutcome::few_points ? 1 : 0;
  repeated += outcome == ScanOutcome::repeated ? 1 : 0;
  lost += outcome == ScanOutcome::lost || outcome == ScanOutcome::restarted ? 1 : 0;
  restarts += outcome == ScanOutcome::restarted ? 1 : 0;
  degenerate += registered && update.degeneracy.unconstrained > 0 ? 1 : 0;
  not_converged += registered && !update.converged ? 1 : 0;
  ambiguous_start |= update.ambiguous;
  // Half a scan: two sensors' clocks and a scan that starts late stay below it, a missing scan does not.
  const double duration_s = (scan.end() - scan.start).seconds();
  gaps += scans > 0 && (scan.start - last_end_).seconds() > duration_s / 2 ? 1 : 0;
  last_end_ = scan.end();
  ++scans;
}

std::string OdometryReport::trouble() const {
  std::vector<std::string> parts;
  if (extrapolated > 0) {
    parts.push_back(fmt::format(
        "{} of {} scans could not be registered, the first of them scan {} of the run: their motion is "
        "extrapolated, the map was restarted {} times",
        extrapolated, scans, first_extrapolated, restarts));
  }
  if (gaps > 0) parts.push_back(fmt::format("scans are missing at {} places", gaps));
  if (degenerate > 0)
    parts.push_back(
        fmt::format("in {} scans the points do not constrain every direction of motion", degenerate));
  if (not_converged > 0) parts.push_back(fmt::format("{} scans did not converge", not_converged));
  if (ambiguous_start)
    parts.emplace_back(
        "the speed at the start is uncertain: another motion explains the first scans as well");
  return parts.empty() ? "" : fmt::format("odometry: {}", fmt::join(parts, "; "));
}

std::string trouble_of(const OdometryUpdate& update) {
  switch (update.outcome) {
    case ScanOutcome::first:
      return "";
    case ScanOutcome::few_points:
      return "too few points to register: the motion is extrapolated";
    case ScanOutcome::repeated:
      return "the points of the scan before, delivered again: the motion is extrapolated";
    case ScanOutcome::lost:
      return "the points do not match the map: the motion is extrapolated";
    case ScanOutcome::restarted:
      return "the points of several scans did not match the map: the map was restarted";
    case ScanOutcome::registered:
      break;
  }
  if (update.ambiguous) return "another motion explains the first scans as well: the speed is uncertain";
  if (!update.converged) return "the registration did not converge";
  if (update.degeneracy.unconstrained == 0) return "";
  return fmt::format("the points do not constrain {} of 3 directions of motion",
                     update.degeneracy.unconstrained);
}

}  // namespace mapless
