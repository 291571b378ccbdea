#include "simulation/traffic/right_of_way.hpp"

#include <algorithm>
#include <cmath>

namespace mapless::inline v1 {
namespace {

using Eigen::Vector2d;

// Timing and dimensions of urban traffic. Chosen: plausible, and free of deadlocks over 600 s (scenes_test,
// traffic_test).
constexpr double kCycle_s = 36,
                 kGreen_s = 15;     // of the traffic lights: 3 s all red between the two directions
constexpr double kWalk_s = 6;       // after the start of green in which pedestrians may step onto the street
constexpr double kPatience_s = 12;  // after which a vehicle that turns left ignores oncoming traffic
constexpr double kOncoming_s = 5;   // time to the stop line within which a vehicle is oncoming
constexpr double kLongVehicle_m = 7;  // longer vehicles need more room when paths cross
constexpr double kLongClearance_m = 3.3, kClearance_m = 3.0;
constexpr double kSameStreet_m = 2.5;  // between entries or exits of one lane
constexpr double kRoomBetween_m = 3;   // between vehicles that queue

double green_for_s(const Junction& junction, bool along_x, double t_s) {
  return std::fmod(t_s + junction.offset_s + (along_x ? 0 : kCycle_s / 2), kCycle_s);
}

bool share_junction(const Agent& a, const Agent& b) {
  return a.passage() != nullptr && b.passage() != nullptr && a.passage()->junction == b.passage()->junction;
}

bool lines_meet(const Agent& a, const Agent& b) {
  const bool is_long = std::max(a.length_m, b.length_m) > kLongVehicle_m;
  const double room = is_long ? kLongClearance_m : kClearance_m;
  for (const Vector2d& p : a.passage()->line) {
    for (const Vector2d& q : b.passage()->line) {
      if ((p - q).squaredNorm() < room * room) return true;
    }
  }
  return false;
}

bool same_exit(const Agent& a, const Agent& b) {
  return (a.passage()->line.back() - b.passage()->line.back()).norm() < kSameStreet_m;
}

double until_line(const Agent& agent) { return agent.passage()->begin_m - agent.front_m(); }

bool is_oncoming(const Agent& me, const Agent& other) {
  return !other.passage()->turns_left && other.passage()->along_x == me.passage()->along_x &&
         !same_approach(me, other) && until_line(other) < kOncoming_s * std::max(other.v, 3.0);
}

// True if there is room behind the junction for vehicle i and for those with the right of way to the same
// exit.
bool has_room_beyond(const std::vector<Agent>& agents, std::size_t i) {
  const Agent& me = agents[i];
  double needed = me.length_m + kRoomBetween_m;
  for (const Agent& other : agents) {
    if (&other != &me && other.holds && share_junction(me, other) && same_exit(me, other))
      needed += other.length_m + kRoomBetween_m;
  }
  const double end = me.passage()->end_m;
  for (const Agent& other : agents) {
    if (&other == &me || on_foot(other.user.object_class) || other.v > 3) continue;
    if ((other.position - me.passage()->line.back()).norm() > needed + 15) continue;
    for (double s = end; s < end + needed; s += 2) {
      if (distance_to(other, me.user.path->at(s)) < 1.5) return false;
    }
  }
  return true;
}

double distance_to_segment(const Vector2d& p, const Vector2d& a, const Vector2d& b) {
  const Vector2d along = b - a;
  const double u = std::clamp((p - a).dot(along) / along.squaredNorm(), 0.0, 1.0);
  return (p - a - u * along).norm();
}

}  // namespace

bool is_green(const Junction& junction, bool along_x, double t_s) {
  return green_for_s(junction, along_x, t_s) < kGreen_s;
}

bool same_approach(const Agent& a, const Agent& b) {
  return share_junction(a, b) &&
         (a.passage()->line.front() - b.passage()->line.front()).norm() < kSameStreet_m;
}

bool may_enter(const std::vector<Agent>& agents, std::size_t i, const std::vector<Junction>& junctions,
               double t_s) {
  const Agent& me = agents[i];
  const Passage& mine = *me.passage();
  if (!is_green(junctions[mine.junction], mine.along_x, t_s)) return false;
  for (std::size_t k = 0; k < agents.size(); ++k) {
    const Agent& other = agents[k];
    if (k == i || !share_junction(me, other)) continue;
    if (same_approach(me, other)) {
      if (!other.holds && until_line(other) < until_line(me)) return false;
      continue;
    }
    const bool in_my_way =
        other.holds || (mine.turns_left && me.waited_s < kPatience_s && is_oncoming(me, other));
    if (in_my_way && lines_meet(me, other)) return false;
  }
  return has_room_beyond(agents, i);
}

bool may_cross(const std::vector<Agent>& agents, std::size_t i, const std::vector<Junction>& junctions,
               double t_s) {
  const Agent& me = agents[i];
  const StreetCrossing& crossing = *me.crossing();
  if (green_for_s(junctions[crossing.junction], crossing.along_x, t_s) > kWalk_s) return false;
  const Vector2d from = me.user.path->at(crossing.from_m);
  const Vector2d to = me.user.path->at(crossing.to_m);
  return std::none_of(agents.begin(), agents.end(), [&](const Agent& other) {
    const Passage* passage = other.holds ? other.passage() : nullptr;
    if (passage == nullptr || passage->junction != crossing.junction || other.v < 0.5) return false;
    return std::any_of(passage->line.begin(), passage->line.end(), [&](const Vector2d& p) {
      const bool ahead = (p - other.position).dot(other.heading) > -other.length_m / 2;
      return ahead && distance_to_segment(p, from, to) < 1.5;
    });
  });
}

}  // namespace mapless
