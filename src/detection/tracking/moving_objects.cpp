#include "detection/tracking/moving_objects.hpp"

#include <utility>

#include "detection/dynamic_returns.hpp"
#include "detection/object_number.hpp"
#include "detection/scan_trajectory.hpp"
#include "detection/tracking/motion_probability.hpp"
#include <mapless/core/time.hpp>

namespace mapless::inline v1 {

Detection MovingObjects::classify(ObjectProposals proposed) {
  Detection detection;
  detection.scan = std::move(proposed.scan);
  detection.trace = std::move(proposed.trace);
  detection.object = std::move(proposed.object);
  detection.objects = proposed.objects;
  detection.seconds = proposed.seconds;
  const Time now = detection.scan->start;
  detection.tracked = timed(detection.seconds.tracking, [&] {
    return tracker_.process(detection, ScanTrajectory(*detection.scan, std::move(proposed.column_states)),
                            proposed.rays);
  });
  if (method_ == DetectionMethod::published) return detection;
  std::vector<bool> moves;
  motions_.assign(proposed.evidence.size(), {});
  for (const TrackedObject& object : detection.tracked) {
    TrackMotion& state = states_[object.id];
    state = classifier_.update(state, object, proposed.evidence[object.number - 1U], now);
    moves.push_back(state.moves);
    motions_[object.number - 1U] = state;
  }
  erase_dropped(states_, now);
  detection.probability = motion_probabilities(proposed.votes, detection.object, motions_);
  keep_moving(moves, detection);
  give_ids(detection.tracked, now);
  return detection;
}

void MovingObjects::give_ids(std::vector<TrackedObject>& moving, Time now) {
  std::erase_if(ids_,
                [now](const auto& entry) { return (now - entry.second.moved).seconds() > kLongestRest_s; });
  for (TrackedObject& object : moving) {
    GivenId& given = ids_[object.id];
    if (given.id == 0) given.id = next_id_++;
    given.moved = now;
    object.id = given.id;
  }
}

void keep_moving(const std::vector<bool>& moves, Detection& detection) {
  // Objects beyond the last number share it and move together.
  std::vector<std::uint16_t> numbers(kMaxObjectNumber + 1, 0);
  std::vector<TrackedObject> moving;
  for (std::size_t k = 0; k < moves.size(); ++k) {
    if (!moves[k]) continue;
    TrackedObject object = detection.tracked[k];
    object.number = numbers[object.number] = static_cast<std::uint16_t>(moving.size() + 1);
    moving.push_back(object);
  }
  for_each_dynamic(detection.object, [&](std::size_t i) {
    const std::uint16_t number = numbers[detection.object[i]];
    detection.object[i] = number;
    if (number == 0) detection.trace[i].growth = GrowthVerdict::static_track;
  });
  detection.objects = static_cast<int>(moving.size());
  detection.tracked = std::move(moving);
}

}  // namespace mapless
