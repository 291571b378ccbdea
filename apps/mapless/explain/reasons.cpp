#include "explain/reasons.hpp"

#include <cmath>

#include <fmt/format.h>

namespace mapless::app {

const std::array<ReasonText, kObservationKinds> kObservationTexts = {{
    {"not queried",
     "not queried: the scans before it settled the point as static, so it counts as a surface too"},
    {"no ray", "no ray passes near enough"},
    {"faulty", "the nearest ray gave no usable return"},
    {"edge",
     "its ray goes on for {beyond} m, but a neighbouring one ends short, or there is none on the other side: "
     "no "
     "answer"},
    {"through", "free: its ray passes within {aside} m and goes on for {beyond} m"},
    {"beside",
     "free: its ray passes {aside} m aside (more than {through_within} m) and goes on for {beyond} m"},
    {"nothing met", "free: its ray passes within {aside} m and met nothing within range"},
    {"surface", "a surface here: {off}"},
    {"moving surface", "a surface here, found dynamic in that scan: {off}"},
    {"hidden", "hidden: its ray ends {short} m before the point"},
    {"hidden", "hidden: its ray ends {short} m before the point, on something that is still there"},
    {"left", "hidden by something {distance} m away that has left since: probably the same object"},
    {"uncovered",
     "hidden by something {distance} m away that has left, but the next scan sees a surface here: uncovered, "
     "no "
     "vote"},
    {"slow surface", "a surface here: {off}; no vote, as no older scan saw one: it may be slow"},
}};

const std::array<ReasonText, kPointSteps> kPointTexts = {{
    {"own vehicle",
     "It lies on the sensor's own vehicle, whose returns keep their range while it drives: such "
     "points count as a surface in every scan."},
    {"no evidence", "Its votes sum to 0: no scan says that it moves."},
    {"static votes",
     "Its votes sum to {votes}, and a point is evidence of motion above 0. {near} of its 14 "
     "neighbours are part of an object; a hole is filled from {fill_neighbours} on (of two "
     "lasers at least, where these are far apart), at {firmly_static} votes or more."},
    {"little support",
     "Its votes sum to {votes}, with those of {supporters} linked neighbours to {support}: a "
     "seed takes {seed_score}. No linked point within 2 lasers and 4 columns is part of an "
     "object it could join."},
    {"few seeds",
     "It is a seed ({support} votes with its neighbours), but fewer than {min_seeds} linked seeds "
     "are around it."},
    {"seed",
     "It is a seed: its votes {votes} and those of {supporters} linked neighbours sum to {support}, and "
     "{seed_score} suffice."},
    {"region growth",
     "It joins the object it is linked to: its votes sum to {votes}, above 0, or to at least "
     "{firmly_static} where a scan saw through."},
    {"hole filled",
     "It is filled in: {near} of its 14 neighbours are part of the object, {fill_neighbours} "
     "suffice, and its votes {votes} are not below {firmly_static}."},
    {"tangential surface",
     "Its surface slides along itself, or no earlier scan observed it: linked points of the object go on in "
     "it, so its votes ({votes}) are not held against it."},
    {"body completed",
     "It lies within the radius of a dynamic object, at most 1.5 m, of one of its points, and its votes "
     "({votes}) are at least those of one scan that saw through it."},
    {"side completed",
     "It lies in the plane of the side of a dynamic object, which slides along itself, so its votes "
     "({votes}) are not held against it: the rear of the side was seen to move."},
}};

const std::array<ReasonText, kTrackReasons> kTrackTexts = {{
    {"moves on", "It moved before, and nothing says that it has stopped: {speed} +- {std} m/s."},
    {"begins to move",
     "It begins to move: {speed} +- {std} m/s, evidence {evidence} of {required} needed, "
     "displaced by {displacement} m as the rays show (at least {min_displacement} m)."},
    {"follows a path",
     "Its places in the scans of the last second follow one velocity, which chance does not explain; so it "
     "moves, whatever its evidence in this scan."},
    {"slow", "It is slower than {min_speed} m/s: {speed} +- {std} m/s."},
    {"may stand", "Its velocity is within two standard deviations of zero: {speed} +- {std} m/s."},
    {"not displaced",
     "The rays show no displacement: {displacement} m, and {min_displacement} m are needed."},
    {"not confirmed",
     "It was seen to stand, and the displacement that the rays show, {displacement} m, does not "
     "confirm its velocity of {speed} m/s."},
    {"little evidence",
     "Its evidence is {evidence}, and to begin it needs {required}. Within 3 m of it are {clutter} sets of "
     "points that are too faint for objects; each raises the evidence that it needs."},
    {"stops: slow",
     "It stops: {speed} +- {std} m/s, where {min_speed} m/s are needed, or a displacement if no velocity "
     "is known (the rays show {displacement} m)."},
    {"stops: unsupported",
     "It stops: its velocity is known to {std} m/s only, and its evidence is {evidence}."},
    {"static by the rays",
     "The rays of the scans around end on it as if it were static, better than as if it moved at "
     "{speed} m/s."},
    {"static: slides with the sensor",
     "Its points lie on a straight line, and its velocity, {speed} m/s, is along the line and that of the "
     "sensor. A static rail has such a velocity, because the part of it in view moves with the sensor."},
}};

int steps_of(double metres) {
  const auto cm = static_cast<int>(std::lround(100 * metres));
  return cm < 100 ? cm : 90 + static_cast<int>(std::lround(10 * metres));
}

std::string text_of_steps(int steps) {
  return steps < 100 ? fmt::format("{:.2f}", steps / 100.0) : fmt::format("{:.1f}", (steps - 90) / 10.0);
}

ObservationKind kind_of(const Observation& o, const DecisionLimits& limits) {
  using enum ObservationKind;
  if (o.verdict == FreespaceVerdict::not_evaluated) return not_queried;
  if (o.laser < 0) return no_ray;
  switch (o.verdict) {
    case FreespaceVerdict::inside:
      if (!o.returned) return nothing_met;
      return static_cast<double>(o.aside_m) <= limits.through_within_m ? through : beside;
    case FreespaceVerdict::border:
      return o.seen_dynamic ? moving_surface : surface;
    case FreespaceVerdict::outside:
      if (o.occluder == OccluderVerdict::still_there) return hider_stays;
      if (o.occluder == OccluderVerdict::left) return hider_left;
      return o.occluder == OccluderVerdict::contradicted ? hider_contradicted : hidden;
    default:
      return std::isnan(o.short_by_m) ? faulty : edge;
  }
}

PointStep step_of(const PointDecision& p, const DecisionLimits& limits) {
  using enum PointStep;
  if (p.completed == Completion::body) return body_completed;
  if (p.completed == Completion::side) return side_completed;
  if (p.growth == GrowthVerdict::too_small) return few_seeds;
  if (p.growth == GrowthVerdict::seed) return seed;
  if (p.proposed != 0) {
    if (p.votes() > 0 || (p.seen_through && p.votes() >= limits.firmly_static_votes)) return spread;
    return p.near_labelled >= limits.fill_neighbours && p.votes() >= limits.firmly_static_votes ? filled
                                                                                                : tangential;
  }
  if (p.own_vehicle) return own_vehicle;
  if (p.votes() > 0) return little_support;
  return p.votes() == 0 ? nothing_observed : static_votes;
}

}  // namespace mapless::app
