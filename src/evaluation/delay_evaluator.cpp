#include <algorithm>
#include <cmath>
#include <limits>

#include "evaluation/scan_checks.hpp"
#include <mapless/evaluation/evaluator.hpp>
#include <mapless/io/labels.hpp>

namespace mapless::inline v1 {
namespace {

// Speeds [m/s]: of the true labels, of a standing object, and of one that really moves.
constexpr double kDynamic_mps = 0.2, kStanding_mps = 0.1, kMoving_mps = 0.5;
constexpr std::int64_t kFewestPoints = 20;  // of the object in the first scan of an event
// In scans: an event is followed for so long, and looks back so far.
constexpr std::size_t kFollowed = 25, kStoodBefore = 6, kMovedBefore = 12, kStandsAfter = 10;
constexpr std::size_t kFewestBefore = 5, kFewestAfter = 5;
constexpr double kNever = std::numeric_limits<double>::infinity();

// The number of scans within which at least the share `q` of the events ended; absent where that many never
// did.
std::optional<double> within(std::vector<double> scans, double q) {
  if (scans.empty()) return std::nullopt;
  std::sort(scans.begin(), scans.end());
  const double last = scans[static_cast<std::size_t>(std::ceil(q * static_cast<double>(scans.size()))) - 1];
  return last == kNever ? std::nullopt : std::optional(last);
}

Delays delays_of(const std::vector<double>& scans) {
  return {static_cast<std::int64_t>(scans.size()), std::count(scans.begin(), scans.end(), kNever),
          within(scans, 0.5), within(scans, 0.9)};
}

}  // namespace

DelayEvaluator::DelayEvaluator(const ObjectTruth& truth, std::optional<double> max_range_m)
    : has_states_(truth.has_states), max_range_m_(max_range_m) {
  if (max_range_m_) require_range_limit("DelayEvaluator", *max_range_m_);
  for (const auto& [key, state] : truth.states) speeds_mps_.emplace(key, state.speed_mps);
}

void DelayEvaluator::add(const ScanLabels& scan) {
  require_equal_lengths(scan.number, scan.truth.size(), scan.result.size(), scan.ranges_m.size());
  if (!has_states_) return;
  std::map<std::uint32_t, Sighting> sightings;
  for (std::size_t i = 0; i < scan.truth.size(); ++i) {
    const std::uint32_t id = scan.truth[i] >> 16;
    if (id == 0 || motion_of_label(scan.truth[i]) == MotionTruth::unknown) continue;
    if (max_range_m_ && !(static_cast<double>(scan.ranges_m[i]) <= *max_range_m_)) continue;
    Sighting& sighting = sightings[id];
    ++sighting.points;
    if (motion_of_label(scan.result[i]) == MotionTruth::moving) ++sighting.called;
  }
  for (auto& [id, sighting] : sightings) {
    const auto speed = speeds_mps_.find({scan.number, id});
    if (speed == speeds_mps_.end()) continue;
    sighting.scan = scan.number;
    sighting.speed_mps = speed->second;
    histories_[id].push_back(sighting);
  }
}

bool DelayEvaluator::starts(const History& history, std::size_t at) {
  if (at < kFewestBefore || history[at].points < kFewestPoints) return false;
  if (history[at].speed_mps <= kDynamic_mps || history[at - 1].speed_mps > kDynamic_mps) return false;
  for (std::size_t i = at - std::min(at, kStoodBefore); i + 1 < at; ++i) {
    if (history[i].speed_mps >= kStanding_mps) return false;
  }
  const std::size_t end = std::min(history.size(), at + kFollowed);
  return std::any_of(history.begin() + static_cast<std::ptrdiff_t>(at),
                     history.begin() + static_cast<std::ptrdiff_t>(end),
                     [](const Sighting& s) { return s.speed_mps >= kMoving_mps; });
}

bool DelayEvaluator::stops(const History& history, std::size_t at) {
  if (at < kFewestBefore || history[at].points < kFewestPoints || history.size() < at + kFewestAfter)
    return false;
  if (history[at].speed_mps >= kStanding_mps || history[at - 1].speed_mps < kStanding_mps) return false;
  const auto faster_than = [&](double speed_mps, std::size_t from, std::size_t to) {
    return std::any_of(history.begin() + static_cast<std::ptrdiff_t>(from),
                       history.begin() + static_cast<std::ptrdiff_t>(std::min(to, history.size())),
                       [speed_mps](const Sighting& s) { return s.speed_mps > speed_mps; });
  };
  return faster_than(kMoving_mps, at - std::min(at, kMovedBefore), at) &&
         !faster_than(kStanding_mps, at, at + kStandsAfter);
}

std::optional<DelayReport> DelayEvaluator::report() const {
  if (!has_states_) return std::nullopt;
  const auto delay = [](const History& history, std::size_t at, const auto& ended) {
    for (std::size_t i = at; i < std::min(history.size(), at + kFollowed); ++i) {
      if (ended(history[i])) return static_cast<double>(history[i].scan - history[at].scan);
    }
    return kNever;
  };
  std::vector<double> start, stop;
  for (const auto& [id, history] : histories_) {
    for (std::size_t at = kFewestBefore; at < history.size(); ++at) {
      if (starts(history, at))
        start.push_back(delay(history, at, [](const Sighting& s) { return 2 * s.called >= s.points; }));
      if (stops(history, at))
        stop.push_back(delay(history, at, [](const Sighting& s) { return 10 * s.called < s.points; }));
    }
  }
  return DelayReport{delays_of(start), delays_of(stop)};
}

}  // namespace mapless
