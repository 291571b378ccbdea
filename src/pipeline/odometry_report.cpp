#include <algorithm>
#include <vector>

#include <fmt/format.h>

#include <mapless/pipeline/online_detector.hpp>

namespace mapless::inline v1 {

void OdometryReport::add(const LidarScan& scan, const OdometryUpdate& update) {
  // Half a scan: two sensors' clocks and a scan that starts late stay below it, a missing scan does not.
  const double duration_s = (scan.end() - scan.start).seconds();
  gaps_ += !states_.empty() && (scan.start - last_end_).seconds() > duration_s / 2 ? 1 : 0;
  last_end_ = scan.end();
  if (update.outcome == ScanOutcome::restarted) restarts_.push_back(states_.size());
  states_.push_back(update.state);
  const std::size_t decided = std::min(update.decided_scans, states_.size());
  std::fill(states_.end() - static_cast<std::ptrdiff_t>(decided), states_.end(), update.state);
}

std::size_t OdometryReport::count(MotionState state) const {
  return static_cast<std::size_t>(std::count(states_.begin(), states_.end(), state));
}

std::string OdometryReport::trouble() const {
  std::vector<std::string> parts;
  if (const std::size_t lost = count(MotionState::lost); lost > 0) {
    const auto first = std::find(states_.begin(), states_.end(), MotionState::lost) - states_.begin();
    parts.push_back(fmt::format("the motion is lost in {} of {} scans, the first of them scan {} of the run",
                                lost, scans(), first));
  }
  if (!restarts_.empty())
    parts.push_back(fmt::format("begun anew at scan {} of the run", fmt::join(restarts_, ", ")));
  if (const std::size_t degenerate = count(MotionState::degenerate); degenerate > 0)
    parts.push_back(fmt::format("the motion is degenerate in {} scans", degenerate));
  if (gaps_ > 0) parts.push_back(fmt::format("scans are missing at {} places", gaps_));
  return parts.empty() ? "" : fmt::format("odometry: {}", fmt::join(parts, "; "));
}

std::string trouble_of(const OdometryUpdate& update) {
  switch (update.outcome) {
    case ScanOutcome::first:
    case ScanOutcome::restarted:
    case ScanOutcome::registered:
      break;
    case ScanOutcome::few_points:
      return "too few points to register: the motion is extrapolated";
    case ScanOutcome::repeated:
      return "the points of the scan before, delivered again: the motion is extrapolated";
    case ScanOutcome::unmatched:
      return "the points do not match the map: the motion is extrapolated";
    case ScanOutcome::unsupported:
      return "too few points support the motion";
  }
  if (update.state == MotionState::lost) return "the motion of the first scans is not known";
  return update.state == MotionState::degenerate
             ? "the motion is degenerate: a direction is open, or its start is not decided"
             : "";
}

}  // namespace mapless
