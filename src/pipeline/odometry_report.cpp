#include <algorithm>
#include <vector>

#include <fmt/format.h>

#include <mapless/pipeline/online_detector.hpp>

namespace mapless::inline v1 {
namespace {

// Numbers of restarts in one line.
constexpr std::size_t kMostRestartsNamed = 8;

}  // namespace

void OdometryReport::add(const LidarScan& scan, const OdometryUpdate& update) {
  // Half a scan: two sensors' clocks and a scan that starts late stay below it, a missing scan does not.
  const double duration_s = (scan.end() - scan.start).seconds();
  gaps_ += scans_ > 0 && (scan.start - last_end_).seconds() > duration_s / 2 ? 1 : 0;
  last_end_ = scan.end();
  if (update.outcome == ScanOutcome::restarted) {
    restarts_.push_back(scans_);
    settle(0);
    starting_ = true;
  }
  ++scans_;
  undecided_.push_back(update.state);
  const std::size_t decided = std::min(update.decided_scans, undecided_.size());
  std::fill(undecided_.end() - static_cast<std::ptrdiff_t>(decided), undecided_.end(), update.state);
  if (update.decided_scans > 1) starting_ = false;
  settle(starting_ ? kMostStartUpScans : 0);
}

// No later scan changes the states known so far, but for the last `still_open`.
void OdometryReport::settle(std::size_t still_open) {
  if (undecided_.size() <= still_open) return;
  const std::size_t first = scans_ - undecided_.size();
  const auto end = undecided_.end() - static_cast<std::ptrdiff_t>(still_open);
  const auto lost = std::find(undecided_.begin(), end, MotionState::lost);
  if (!first_lost_ && lost != end) first_lost_ = first + static_cast<std::size_t>(lost - undecided_.begin());
  for (auto state = undecided_.begin(); state != end; ++state) ++counts_[static_cast<std::size_t>(*state)];
  undecided_.erase(undecided_.begin(), end);
}

std::size_t OdometryReport::count(MotionState state) const {
  return counts_[static_cast<std::size_t>(state)] +
         static_cast<std::size_t>(std::count(undecided_.begin(), undecided_.end(), state));
}

std::string OdometryReport::trouble() const {
  if (!undecided_.empty()) {
    OdometryReport settled = *this;
    settled.settle(0);
    return settled.trouble();
  }
  std::vector<std::string> parts;
  if (first_lost_) {
    parts.push_back(fmt::format("the motion is lost in {} of {} scans, the first of them scan {} of the run",
                                count(MotionState::lost), scans_, *first_lost_));
  }
  if (!restarts_.empty()) {
    const std::size_t named = std::min(restarts_.size(), kMostRestartsNamed);
    parts.push_back(fmt::format(
        "begun anew at scan {} of the run",
        fmt::join(restarts_.begin(), restarts_.begin() + static_cast<std::ptrdiff_t>(named), ", ")));
    if (restarts_.size() > named)
      parts.back() += fmt::format(", and {} times more", restarts_.size() - named);
  }
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
