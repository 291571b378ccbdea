#include "simulation/traffic.hpp"

#include <algorithm>
#include <cmath>

#include "simulation/bodies.hpp"
#include "simulation/random.hpp"

namespace mapless {
namespace {

using Eigen::Vector2d;

constexpr double kComfortBraking = 2.0;  // [m/s^2]
constexpr double kHardestBraking = 7.0;
constexpr double kLateral = 2.2;   // acceleration taken in bends [m/s^2]
constexpr double kCorridor = 1.7;  // whoever is nearer than this to my path ahead is in my way [m]
constexpr double kMinimumGap = 2.0;
constexpr double kHeadway_s = 1.3;
constexpr double kCycle_s = 36;
constexpr int kPatience = 150;  // steps of standing before going through those who cross

struct StopLine {
  double s;
  std::size_t junction;
  bool along_x;
};

bool on_foot(ObjectClass c) { return c == ObjectClass::person || c == ObjectClass::dog; }

bool is_green(const Junction& junction, bool along_x, double t_s) {
  const double phase = std::fmod(t_s + junction.offset_s, kCycle_s);
  return along_x ? phase < 15 : phase > 18 && phase < 33;
}

/// A user under way.
struct Agent {
  RoadUser user;
  double length = 4;
  std::vector<double> speed_limit;  // per metre of the path
  std::vector<StopLine> stop_lines;
  std::size_t next_line = 0;
  double s = 0, v = 0, a = 0;
  Vector2d position = Vector2d::Zero();
  Vector2d heading = Vector2d::UnitX();
  int stuck = 0;
};

// The speed of every metre: bends first, then backwards so that braking begins in time.
std::vector<double> speed_limits(const RoadUser& user) {
  const auto n = static_cast<std::size_t>(user.path->length_m()) + 1;
  std::vector<double> limit(n, user.desired_speed);
  if (on_foot(user.object_class)) return limit;
  for (std::size_t i = 0; i < n; ++i) {
    const auto s = static_cast<double>(i);
    const double cosine = user.path->heading(s - 2, 2).dot(user.path->heading(s + 2, 2));
    const double curvature = std::acos(std::clamp(cosine, -1.0, 1.0)) / 4;
    if (curvature > 1e-4) limit[i] = std::min(limit[i], std::sqrt(kLateral / curvature));
  }
  for (std::size_t i = n - 1; i-- > 0;)
    limit[i] = std::min(limit[i], std::sqrt(limit[i + 1] * limit[i + 1] + 2 * 1.5));
  return limit;
}

std::vector<StopLine> stop_lines(const RoadUser& user, const std::vector<Junction>& junctions) {
  std::vector<StopLine> lines;
  if (on_foot(user.object_class)) return lines;
  std::vector<bool> inside(junctions.size(), false);
  for (double s = 0; s < user.path->length_m(); s += 1) {
    const Vector2d p = user.path->at(s);
    for (std::size_t j = 0; j < junctions.size(); ++j) {
      const bool now = (p - junctions[j].centre).cwiseAbs().maxCoeff() < junctions[j].half_size_m;
      if (now && !inside[j]) {
        const Vector2d h = user.path->heading(s - 2, 2);
        lines.push_back({s - 1, j, std::abs(h.x()) > std::abs(h.y())});
      }
      inside[j] = now;
    }
  }
  return lines;
}

// Intelligent driver model (Treiber et al. 2000).
double free_acceleration(double v, double desired) {
  return 1.8 * (1 - std::pow(v / std::max(desired, 0.1), 4));
}

double following(double v, double desired, double gap, double leader_speed) {
  const double wanted =
      kMinimumGap +
      std::max(0.0, v * kHeadway_s + v * (v - leader_speed) / (2 * std::sqrt(1.8 * kComfortBraking)));
  const double ratio = wanted / std::max(gap, 0.3);
  return free_acceleration(v, desired) - 1.8 * ratio * ratio;
}

class Traffic {
 public:
  Traffic(const std::vector<RoadUser>& users, const std::vector<Junction>& junctions, std::uint64_t seed)
      : junctions_(junctions), seed_(seed) {
    for (const RoadUser& user : users) {
      Agent agent;
      agent.user = user;
      agent.length = body_length(user.object_class);
      agent.speed_limit = speed_limits(user);
      agent.stop_lines = stop_lines(user, junctions);
      agent.s = user.start_m;
      agent.v = limit_at(agent, agent.s);
      agents_.push_back(std::move(agent));
    }
    place_all();
  }

  void step(double t_s) {
    for (std::size_t i = 0; i < agents_.size(); ++i) agents_[i].a = acceleration(i, t_s);
    for (Agent& agent : agents_) {
      const double v = std::max(0.0, agent.v + agent.a * Track::kStep_s);
      agent.s += (agent.v + v) / 2 * Track::kStep_s;
      agent.v = v;
    }
    place_all();
  }

  [[nodiscard]] const std::vector<Agent>& agents() const { return agents_; }

 private:
  static double limit_at(const Agent& agent, double s) {
    const double last = static_cast<double>(agent.speed_limit.size() - 1);
    return agent.speed_limit[static_cast<std::size_t>(std::clamp(s, 0.0, last))];
  }

  void place_all() {
    for (Agent& agent : agents_) {
      agent.position = agent.user.path->at(agent.s);
      agent.heading = agent.user.path->heading(agent.s, 2);
    }
  }

  double walker(std::size_t i, double t_s) const {
    const Agent& agent = agents_[i];
    double wanted = agent.user.desired_speed;
    if (agent.user.stop_every_s > 0) {
      constexpr double kStop_s = 6;
      const auto period = static_cast<std::uint64_t>(t_s / kStop_s);
      if (unit_number(random_bits({seed_, i, period})) < kStop_s / agent.user.stop_every_s) wanted = 0;
    }
    return std::clamp((wanted - agent.v) / 0.5, -2.0, 1.5);
  }

  double acceleration(std::size_t i, double t_s) {
    Agent& agent = agents_[i];
    if (on_foot(agent.user.object_class)) return walker(i, t_s);
    const double desired = limit_at(agent, agent.s);
    double a = free_acceleration(agent.v, desired);
    if (agent.v > desired) a = std::max(a, -2.5);
    a = std::min(a, for_lights(agent, t_s, desired));
    const bool impatient = agent.stuck > kPatience;
    a = std::min(a, for_others(i, desired, impatient));
    agent.stuck = agent.v < 0.1 ? agent.stuck + 1 : impatient && agent.v < 3 ? agent.stuck : 0;
    return std::clamp(a, -kHardestBraking, 2.5);
  }

  double for_lights(Agent& agent, double t_s, double desired) const {
    const double front = agent.s + agent.length / 2;
    while (agent.next_line < agent.stop_lines.size() && agent.stop_lines[agent.next_line].s < front - 0.5)
      ++agent.next_line;
    if (agent.next_line == agent.stop_lines.size()) return kHardestBraking;
    const StopLine& line = agent.stop_lines[agent.next_line];
    const double gap = line.s - front;
    if (gap > 60 || is_green(junctions_[line.junction], line.along_x, t_s)) return kHardestBraking;
    if (agent.v * agent.v > 2 * 5 * gap) return kHardestBraking;  // too late to stop
    agent.stuck = 0;                                              // it is the light that keeps us
    return following(agent.v, desired, gap + kMinimumGap - 0.5, 0);
  }

  // Who has waited too long for those who cross waits only for those ahead in his lane.
  double for_others(std::size_t i, double desired, bool impatient) const {
    const Agent& me = agents_[i];
    double a = kHardestBraking;
    const double look = 8 + 3 * me.v + me.v * me.v / 4;
    for (std::size_t j = 0; j < agents_.size(); ++j) {
      if (j == i) continue;
      const Agent& other = agents_[j];
      const Vector2d apart = other.position - me.position;
      if (apart.squaredNorm() > (look + 12) * (look + 12)) continue;
      // Whoever comes towards me keeps to his own side.
      const double along = other.heading.dot(me.heading);
      if (!on_foot(other.user.object_class) && along < -0.5) continue;
      if (impatient && along < 0.5) continue;
      const double gap = gap_to(me, other, look);
      if (gap < 0) continue;
      a = std::min(a, following(me.v, desired, gap, std::max(0.0, other.v * along)));
    }
    return a;
  }

  // Along my path, from my front to the other's nearest part; negative where he is not in my way.
  static double gap_to(const Agent& me, const Agent& other, double look) {
    const double half = other.length / 2;
    for (double ahead = me.length / 2; ahead < look + half;) {
      const Vector2d p = me.user.path->at(me.s + ahead);
      const Vector2d apart = other.position - p;
      const double along = std::max(0.0, std::abs(apart.dot(other.heading)) - half);
      const double across = apart.x() * other.heading.y() - apart.y() * other.heading.x();
      const double apart_m = std::hypot(along, across);
      if (apart_m < kCorridor) return std::max(0.0, ahead - me.length / 2 - 0.5);
      ahead += std::max(1.5, apart_m - kCorridor);
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
    for (std::size_t i = 0; i < tracks.size(); ++i)
      tracks[i]->add(traffic.agents()[i].s, traffic.agents()[i].v);
    traffic.step(static_cast<double>(k) * Track::kStep_s);
  }
  return {tracks.begin(), tracks.end()};
}

}  // namespace mapless
