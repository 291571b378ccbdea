#include "detection/moving_objects.hpp"

#include <algorithm>
#include <utility>

#include <Eigen/Cholesky>

#include "detection/object_number.hpp"
#include "detection/scan_trajectory.hpp"
#include "detection/stage_record.hpp"

namespace mapless {
namespace {

// Of the new objects with fewer points every second one is a border effect, and gone in the next scan.
constexpr int kSurePoints = 15;

// A velocity tells more than the advance where its standard deviation is at most so large, or it is so many
// of them.
constexpr double kKnownStd_mps = 0.5;
constexpr double kSure = 2;

constexpr double kMostUnproven_m = 1;  // several times what the rays tell

// Numbers for those objects that `keep` their place among the old ones, 0 for the others.
std::vector<std::uint16_t> new_numbers(const std::vector<bool>& keep) {
  std::vector<std::uint16_t> numbers(keep.size(), 0);
  std::uint16_t next = 0;
  for (std::size_t old = 1; old < keep.size(); ++old) {
    if (keep[old]) numbers[old] = ++next;
  }
  return numbers;
}

// What slides along itself, or is far, has no velocity that could be told from 0.
bool velocity_is_known(const TrackedObject& object) {
  const double square = object.velocity_0.dot(object.velocity_covariance_0.ldlt().solve(object.velocity_0));
  return object.velocity_std_0().maxCoeff() <= kKnownStd_mps || square > kSure * kSure;
}

void renumber(const std::vector<std::uint16_t>& numbers, Detection& detection) {
  for (std::size_t i = 0; i < detection.object.size(); ++i) {
    const std::uint16_t old = detection.object[i];
    if (old == 0) continue;
    detection.object[i] = numbers[old];
    if (numbers[old] == 0) detection.trace[i].growth = GrowthVerdict::stopped;
  }
  std::vector<TrackedObject>& tracked = detection.tracked;
  for (TrackedObject& object : tracked) object.number = numbers[object.number];
  std::erase_if(tracked, [](const TrackedObject& object) { return object.number == 0; });
  detection.objects = static_cast<int>(tracked.size());
}

}  // namespace

Detection MovingObjects::judge(ProposedObjects proposed) {
  Detection detection = std::move(proposed.detection);
  const Time now = detection.scan->start;
  detection.tracked = timed(detection.seconds.tracking, [&] {
    return tracker_.process(detection, ScanTrajectory(*detection.scan, std::move(proposed.column_states)));
  });
  if (parameters_.method == DetectionMethod::published) return detection;
  // Where there are more objects than numbers the last of them share one, and move together.
  const auto count = static_cast<std::size_t>(std::min(detection.objects, kMaxObjectNumber));
  std::vector<bool> keep(count + 1, false);
  for (const TrackedObject& object : detection.tracked) {
    State& state = states_[object.id];
    update(object, proposed.advance_m[object.number - 1U], now, state);
    state.seen = now;
    keep[object.number] = state.moves;
  }
  forget_absent(now);
  renumber(new_numbers(keep), detection);
  return detection;
}

void MovingObjects::update(const TrackedObject& object, float advance_m, Time now, State& state) const {
  const VotingParameters& p = parameters_.voting;
  const bool advances = static_cast<double>(advance_m) >= p.min_advance_m;
  if (object.age == 1) {
    state.moves = advances && object.points >= kSurePoints;
    return;
  }
  const bool slow = velocity_is_known(object) ? object.velocity_0.norm() < p.min_speed_mps : !advances;
  const bool was_slow = std::exchange(state.slow, slow);
  const double went_m = object.velocity_0.norm() * (now - state.seen).seconds();
  state.unproven_m = advances ? 0 : state.unproven_m + went_m;
  state.moves =
      state.moves ? !(state.slow && was_slow) && state.unproven_m < kMostUnproven_m : !state.slow && advances;
}

void MovingObjects::forget_absent(Time now) {
  std::erase_if(states_, [now](const auto& entry) {
    return (now - entry.second.seen).seconds() > TrackerParameters{}.longest_absence_s;
  });
}

}  // namespace mapless
