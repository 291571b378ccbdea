#include "detection/tracking/moving_objects.hpp"

#include <cstddef>
#include <utility>

#include <tbb/parallel_for.h>

#include "detection/dynamic_returns.hpp"
#include "detection/object_number.hpp"
#include "detection/scan_trajectory.hpp"
#include "detection/tracking/completion/body_completion.hpp"
#include "detection/tracking/motion_probability.hpp"
#include "detection/tracking/object_members.hpp"
#include "detection/tracking/standing_test.hpp"
#include <mapless/core/time.hpp>

namespace mapless::inline v1 {

Detection MovingObjects::classify(ObjectProposals proposed) {
  std::vector<bool> on_path;
  StageSeconds seconds = proposed.seconds;
  if (method_ == DetectionMethod::voting)
    on_path = timed(seconds.tracking, [&] { return paths_.find(proposed, movers_); });
  Detection detection;
  detection.scan = std::move(proposed.scan);
  detection.trace = std::move(proposed.trace);
  detection.object = std::move(proposed.object);
  detection.objects = proposed.objects;
  detection.seconds = seconds;
  detection.explanation = std::move(proposed.explanation);
  const Time now = detection.scan->start;
  detection.tracked = timed(detection.seconds.tracking, [&] {
    return tracker_.process(detection, ScanTrajectory(*detection.scan, std::move(proposed.column_states)),
                            proposed.rays);
  });
  if (method_ == DetectionMethod::published) return detection;
  std::vector<bool> moved, moves;
  for (const TrackedObject& object : detection.tracked) {
    TrackMotion& state = states_[object.id];
    moved.push_back(state.moves);
    const std::size_t n = object.number - 1U;
    state = classifier_.update(state, object, proposed.evidence[n], now, on_path[n]);
  }
  timed(detection.seconds.tracking, [&] { stop_standing(proposed, detection); });
  motions_.assign(proposed.evidence.size(), {});
  for (const TrackedObject& object : detection.tracked) {
    const TrackMotion& state = states_[object.id];
    moves.push_back(state.moves);
    motions_[object.number - 1U] = state;
  }
  if (detection.explanation) explain(proposed.evidence, moved, detection);
  erase_dropped(states_, now);
  take_off(proposed.rims, detection);
  std::vector<std::uint32_t> completing =
      complete_bodies(proposed.points, proposed.votes, detection.tracked, motions_, detection.object);
  explain(completing, Completion::body, detection);
  const std::vector<std::uint32_t> sides =
      sides_.take(*detection.scan, proposed, detection.tracked, motions_, detection.object);
  explain(sides, Completion::side, detection);
  completing.insert(completing.end(), sides.begin(), sides.end());
  detection.probability = motion_probabilities(proposed.votes, detection.object, motions_);
  keep_moving(moves, detection);
  movers_ = detection.tracked;
  for (const std::uint32_t i : completing) {
    detection.trace[i].growth = GrowthVerdict::grown;
    ++detection.tracked[detection.object[i] - 1U].points;
  }
  give_ids(detection.tracked, now);
  if (detection.explanation) {
    for (ObjectDecision& one : detection.explanation->objects) one.object.id = given_id(one.track);
  }
  return detection;
}

void MovingObjects::explain(const std::vector<ObjectEvidence>& evidence, const std::vector<bool>& moved,
                            Detection& detection) const {
  for (std::size_t k = 0; k < detection.tracked.size(); ++k) {
    const TrackedObject& object = detection.tracked[k];
    const TrackMotion& state = states_.at(object.id);
    const ObjectEvidence& e = evidence[object.number - 1U];
    detection.explanation->objects.push_back({object, object.id, state.moves, moved[k], state.reason, e.votes,
                                              state.evidence, state.required, state.clutter,
                                              e.displacement_m});
  }
}

void MovingObjects::explain(const std::vector<std::uint32_t>& completing, Completion by,
                            Detection& detection) {
  if (!detection.explanation || !detection.explanation->points_recorded) return;
  for (const std::uint32_t i : completing) {
    detection.explanation->points[i].completed = by;
    detection.explanation->points[i].proposed = detection.object[i];
  }
}

std::uint32_t MovingObjects::given_id(std::uint32_t track) const {
  const auto given = ids_.find(track);
  return given == ids_.end() ? 0 : given->second.id;
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

void MovingObjects::take_off(const std::vector<std::int32_t>& rims, Detection& detection) {
  for (const std::int32_t i : rims) {
    std::uint16_t& number = detection.object[static_cast<std::size_t>(i)];
    --detection.tracked[number - 1U].points;
    detection.trace[static_cast<std::size_t>(i)].growth = GrowthVerdict::not_reached;
    number = 0;
  }
}

void MovingObjects::stop_rails(const ObjectProposals& proposed, const std::vector<TrackedObject>& tracked) {
  for (const TrackedObject& object : tracked) {
    TrackMotion& state = states_.at(object.id);
    const Eigen::Vector3f& line_0 = proposed.evidence[object.number - 1U].line_0;
    if (!state.moves || !slides_with_sensor(line_0, object.velocity_0, proposed.sensor_velocity_0)) continue;
    state.moves = false;
    state.reason = TrackReason::slides_with_sensor;
  }
}

// The rays outvote the velocity of a track: its registered surface may be a part that changes.
void MovingObjects::stop_standing(const ObjectProposals& proposed, const Detection& detection) {
  stop_rails(proposed, detection.tracked);
  const ObjectMembers members(detection.object);
  const StandingTest test(*detection.scan, proposed.points, proposed.references, proposed.parameters);
  tbb::parallel_for(std::size_t{0}, detection.tracked.size(), [&](std::size_t k) {
    const TrackedObject& object = detection.tracked[k];
    TrackMotion& state = states_.at(object.id);
    if (!state.moves ||
        !test.stands(members.of(object.number), object.velocity_0, object.velocity_std_0().maxCoeff()))
      return;
    state.moves = false;
    state.reason = TrackReason::stopped_by_rays;
  });
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
