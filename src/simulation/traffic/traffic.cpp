#include "simulation/traffic/traffic.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "simulation/random.hpp"
#include "simulation/traffic/right_of_way.hpp"

namespace mapless::inline v1 {
namespace {

using Eigen::Vector2d;

// Parameters of the intelligent driver model, in the range of Treiber et al. (2000) for cities.
constexpr double kComfortBraking = 2.0;  // [m/s^2]
constexpr double kHardestBraking = 7.0;  // [m/s^2], dry road
constexpr double kAcceleration = 1.8;    // [m/s^2]
constexpr double kMinimumGap = 2.0;      // to a stopped leader [m]
constexpr double kHeadway_s = 1.3;
// Pedestrians. Chosen: they pass each other without contact and never block a vehicle for long
// (traffic_test).
constexpr double kStandStill = 0.1;      // slower is standing [m/s]
constexpr double kLongEnough_s = 2;      // a pedestrian waits for a stopped vehicle in the way
constexpr double kSideways = 0.45;       // lateral speed of evading [m/s]
constexpr double kMostSideways_m = 0.6;  // largest lateral offset
constexpr double kShoulders_m = 0.7;     // between the centres of two pedestrians who pass

// Intelligent driver model (Treiber et al. 2000).
double free_acceleration(double v, double desired) {
  return kAcceleration * (1 - std::pow(v / std::max(desired, 0.1), 4));
}

double following(double v, double desired, double gap, double leader_speed) {
  const double closing = v * (v - leader_speed) / (2 * std::sqrt(kAcceleration * kComfortBraking));
  const double wanted = kMinimumGap + std::max(0.0, v * kHeadway_s + closing);
  const double ratio = wanted / std::max(gap, 0.3);
  return free_acceleration(v, desired) - kAcceleration * ratio * ratio;
}

class Traffic {
 public:
  Traffic(const std::vector<RoadUser>& users, const std::vector<Junction>& junctions, std::uint64_t seed)
      : junctions_(junctions), seed_(seed) {
    for (const RoadUser& user : users) agents_.push_back(make_agent(user, junctions));
  }

  void step(double t_s) {
    for (std::size_t i = 0; i < agents_.size(); ++i) {
      if (on_foot(agents_[i].user.object_class)) {
        agents_[i].a = walker(i, t_s);
        agents_[i].aside_rate = sidestep(i);
      } else {
        agents_[i].a = driver(i, t_s);
      }
    }
    for (Agent& agent : agents_) {
      const double v = std::max(0.0, agent.v + agent.a * Track::kStep_s);
      agent.s += (agent.v + v) / 2 * Track::kStep_s;
      agent.v = v;
      agent.aside_m += agent.aside_rate * Track::kStep_s;
      agent.settle();
    }
  }

  [[nodiscard]] const std::vector<Agent>& agents() const { return agents_; }

 private:
  double walker(std::size_t i, double t_s) {
    Agent& agent = agents_[i];
    double wanted = agent.user.desired_speed;
    if (agent.user.stop_every_s > 0 && !agent.is_on_road()) {
      constexpr double kStop_s = 6;
      const auto period = static_cast<std::uint64_t>(t_s / kStop_s);
      if (unit_number(random_bits({seed_, i, period})) < kStop_s / agent.user.stop_every_s) wanted = 0;
    }
    if (const StreetCrossing* crossing = agent.crossing(); crossing != nullptr && !agent.is_on_road()) {
      const double gap = crossing->from_m - agent.s - 0.3;
      agent.holds = gap < 1 && (agent.holds || may_cross(agents_, i, junctions_, t_s));
      if (!agent.holds) wanted = std::min(wanted, gap < 0.1 ? 0 : std::sqrt(1.2 * gap));
    }
    for (const Agent& other : agents_) {
      if (&other == &agent) continue;
      const Vector2d apart = other.position - agent.position;
      if (!on_foot(other.user.object_class)) {
        // For a limited time: the vehicle may wait for the pedestrian.
        if (agent.is_on_road() && agent.waited_s < kLongEnough_s && stands_before(other, agent)) {
          wanted = 0;
          agent.waited_s += Track::kStep_s;
        }
        continue;
      }
      const double ahead = apart.dot(agent.heading);
      if (ahead < 0 || ahead > 1.5 || std::abs(to_left(agent, apart)) > 0.45) continue;
      const double along = other.heading.dot(agent.heading);
      if (along > 0) wanted = std::min(wanted, other.v * along + 0.2);
    }
    return std::clamp((wanted - agent.v) / 0.3, -2.0, 1.5);
  }

  static bool stands_before(const Agent& vehicle, const Agent& walker) {
    for (const double step : {0.4, 0.8, 1.2}) {
      const Vector2d apart = walker.position + step * walker.heading - vehicle.position;
      if (std::abs(apart.dot(vehicle.heading)) < vehicle.length_m / 2 &&
          std::abs(to_left(vehicle, apart)) < vehicle.half_width_m + 0.3)
        return true;
    }
    return false;
  }

  static double to_left(const Agent& agent, const Vector2d& apart) {
    return agent.heading.x() * apart.y() - agent.heading.y() * apart.x();
  }

  // Lateral speed away from the nearest pedestrian ahead on a collision course (to the right if straight
  // ahead), then back.
  double sidestep(std::size_t i) const {
    const Agent& me = agents_[i];
    double wanted = 0;
    for (const Agent& other : agents_) {
      if (&other == &me || !on_foot(other.user.object_class)) continue;
      const Vector2d apart = other.position - me.position;
      if (apart.squaredNorm() > 25) continue;
      const double ahead = apart.dot(me.heading);
      const double left = to_left(me, apart);
      if (ahead < -0.8 || std::abs(left) > kShoulders_m) continue;
      if (me.v - other.v * other.heading.dot(me.heading) < 0.1 && ahead > 0) continue;
      wanted = me.aside_m + (left < -0.05 ? 1 : -1) * (kShoulders_m - std::abs(left));
      break;
    }
    wanted = std::clamp(wanted, -kMostSideways_m, kMostSideways_m);
    const double fastest = kSideways * std::min(1.0, me.v + 0.2);
    return std::clamp((wanted - me.aside_m) / 0.5, -fastest, fastest);
  }

  double driver(std::size_t i, double t_s) {
    Agent& agent = agents_[i];
    const double desired = agent.limit_at(agent.s);
    double a = free_acceleration(agent.v, desired);
    if (agent.v > desired) a = std::max(a, -2.5);
    a = std::min({a, for_junction(i, t_s, desired), for_others(agent, desired)});
    return std::clamp(a, -kHardestBraking, 2.5);
  }

  double for_junction(std::size_t i, double t_s, double desired) {
    Agent& agent = agents_[i];
    const Passage* passage = agent.passage();
    if (passage == nullptr || agent.holds) return kHardestBraking;
    const double gap = passage->begin_m - agent.front_m();
    if (gap > 60) return kHardestBraking;
    const double decide = agent.v * agent.v / (2 * kComfortBraking) + 0.7 * agent.v + 3;
    const bool green = is_green(junctions_[passage->junction], passage->along_x, t_s);
    if (gap > decide && green) return kHardestBraking;
    if (gap < decide && may_enter(agents_, i, junctions_, t_s)) {
      agent.holds = true;
      return kHardestBraking;
    }
    if (green && agent.v < 1 && gap < 4) agent.waited_s += Track::kStep_s;
    return following(agent.v, desired, std::max(0.0, gap) + kMinimumGap - 0.5, 0);
  }

  double for_others(const Agent& me, double desired) const {
    double a = kHardestBraking;
    const double look = 8 + 3 * me.v + me.v * me.v / 4;
    for (const Agent& other : agents_) {
      if (&other == &me) continue;
      if ((other.position - me.position).squaredNorm() > (look + 12) * (look + 12)) continue;
      a = std::min(a, on_foot(other.user.object_class) ? for_walker(me, other, desired, look)
                                                       : for_vehicle(me, other, desired, look));
    }
    return a;
  }

  // Braking for a pedestrian on the street, at the present and the predicted positions; one who stands lets
  // vehicles pass.
  static double for_walker(const Agent& me, const Agent& walker, double desired, double look) {
    if (!walker.is_on_road()) return kHardestBraking;
    const double room = walker.v < kStandStill ? 0.35 : 1.0;
    double a = kHardestBraking;
    Agent later = walker;
    for (const double ahead_s : {0.0, 1.0, 2.0}) {
      later.position = walker.position + ahead_s * walker.v * walker.heading;
      const double gap = gap_to(me, later, me.half_width_m + room, look);
      if (gap >= 0) a = std::min(a, following(me.v, desired, gap, 0));
    }
    return a;
  }

  // Braking for vehicles in the same direction or from the same street; the right of way settles all others.
  static double for_vehicle(const Agent& me, const Agent& other, double desired, double look) {
    const double gap = gap_to(me, other, me.half_width_m + other.half_width_m + 0.3, look);
    if (gap < 0) return kHardestBraking;
    const double along = other.heading.dot(me.user.path->heading(me.front_m() + gap, 2));
    if (along < 0.3 && !same_approach(me, other)) return kHardestBraking;
    return following(me.v, desired, gap, std::max(0.0, other.v * along));
  }

  // Distance along the path from the front of `me` to the nearest part of `other`; negative if it is not in
  // the corridor.
  static double gap_to(const Agent& me, const Agent& other, double corridor, double look) {
    const double half = me.length_m / 2;
    for (double ahead = half; ahead < look + other.length_m / 2;) {
      const double apart_m = distance_to(other, me.user.path->at(me.s + ahead));
      if (apart_m < corridor) return std::max(0.0, ahead - half - 0.5);
      ahead += std::max(1.0, apart_m - corridor);
    }
    return -1;
  }

  const std::vector<Junction>& junctions_;
  std::uint64_t seed_;
  std::vector<Agent> agents_;
};

}  // namespace

std::vector<std::shared_ptr<const Track>> drive_all(const std::vector<RoadUser>& users,
                                                    const std::vector<Junction>& junctions,
                                                    const Terrain& terrain, double duration_s,
                                                    std::uint64_t seed) {
  Traffic traffic(users, junctions, seed);
  std::vector<std::shared_ptr<Track>> tracks;
  for (const RoadUser& user : users)
    tracks.push_back(std::make_shared<Track>(user.path, user.wheelbase_m, terrain));
  const auto steps = static_cast<long>(std::ceil(duration_s / Track::kStep_s)) + 2;
  for (long k = 0; k <= steps; ++k) {
    for (std::size_t i = 0; i < tracks.size(); ++i) {
      const Agent& agent = traffic.agents()[i];
      tracks[i]->add(agent.s, agent.v, agent.aside_m);
    }
    traffic.step(static_cast<double>(k) * Track::kStep_s);
  }
  return {tracks.begin(), tracks.end()};
}

}  // namespace mapless
