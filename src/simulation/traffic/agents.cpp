#include "simulation/traffic/agents.hpp"

#include <algorithm>
#include <cmath>

#include "simulation/traffic/vehicles.hpp"

namespace mapless::inline v1 {
namespace {

using Eigen::Vector2d;

constexpr double kLateralAcceleration_mps2 = 2.2;  // drivers accept in bends
constexpr double kBendBraking_mps2 = 1.5;          // comfortable braking ahead of bends

// Limits in bends first; then from the end backwards, so that braking starts early enough.
std::vector<double> speed_limits(const RoadUser& user) {
  const auto n = static_cast<std::size_t>(user.path->length_m()) + 1;
  std::vector<double> limit(n, user.desired_speed);
  if (on_foot(user.object_class)) return limit;
  for (std::size_t i = 0; i < n; ++i) {
    const auto s = static_cast<double>(i);
    const double cosine = user.path->heading(s - 2, 2).dot(user.path->heading(s + 2, 2));
    const double curvature = std::acos(std::clamp(cosine, -1.0, 1.0)) / 4;
    if (curvature > 1e-4) limit[i] = std::min(limit[i], std::sqrt(kLateralAcceleration_mps2 / curvature));
  }
  for (std::size_t i = n - 1; i-- > 0;)
    limit[i] = std::min(limit[i], std::sqrt(limit[i + 1] * limit[i + 1] + 2 * kBendBraking_mps2));
  return limit;
}

double cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

std::vector<Passage> passages(const RoadUser& user, const std::vector<Junction>& junctions) {
  std::vector<Passage> out;
  if (on_foot(user.object_class) || junctions.empty()) return out;
  const Passage* under_way = nullptr;
  for (double s = 0; s < user.path->length_m(); s += 1) {
    const Vector2d p = user.path->at(s);
    if (under_way != nullptr) {
      Passage& passage = out.back();
      const Junction& junction = junctions[passage.junction];
      passage.line.push_back(p);
      if ((p - junction.centre).cwiseAbs().maxCoeff() < junction.half_size_m) continue;
      passage.end_m = s;
      const Vector2d in = user.path->heading(passage.begin_m - 2, 2);
      passage.turns_left = cross(in, user.path->heading(s + 2, 2)) > 0.5;
      under_way = nullptr;
      continue;
    }
    for (std::size_t j = 0; j < junctions.size(); ++j) {
      if ((p - junctions[j].centre).cwiseAbs().maxCoeff() >= junctions[j].half_size_m) continue;
      const Vector2d h = user.path->heading(s - 3, 2);
      out.push_back({s - 1, s, j, std::abs(h.x()) > std::abs(h.y()), false, {p}});
      under_way = &out.back();
      break;
    }
  }
  if (under_way != nullptr) out.back().end_m = user.path->length_m();
  return out;
}

}  // namespace

bool on_foot(ObjectClass c) { return c == ObjectClass::person || c == ObjectClass::dog; }

double Agent::limit_at(double at_m) const {
  const double last = static_cast<double>(speed_limit.size() - 1);
  return speed_limit[static_cast<std::size_t>(std::clamp(at_m, 0.0, last))];
}

void Agent::settle() {
  const bool passed = passage() != nullptr ? s - length_m / 2 > passage()->end_m
                                           : crossing() != nullptr && s > crossing()->to_m;
  if (passed) {
    ++next;
    holds = false;
    waited_s = 0;
  }
  heading = user.path->heading(s, 2);
  position = user.path->at(s) + aside_m * Vector2d(-heading.y(), heading.x());
}

Agent make_agent(const RoadUser& user, const std::vector<Junction>& junctions) {
  Agent agent;
  agent.user = user;
  agent.length_m = body_length(user.object_class);
  agent.half_width_m = body_width(user.object_class) / 2;
  agent.speed_limit = speed_limits(user);
  agent.passages = passages(user, junctions);
  agent.s = user.start_m;
  while (agent.passage() != nullptr && agent.passage()->begin_m < agent.front_m()) ++agent.next;
  while (agent.crossing() != nullptr && agent.crossing()->from_m < agent.s) {
    agent.s = std::max(agent.s, agent.crossing()->to_m);
    ++agent.next;
  }
  agent.v = agent.limit_at(agent.s);
  agent.settle();
  return agent;
}

double distance_to(const Agent& other, const Vector2d& p) {
  const Vector2d apart = p - other.position;
  const double along = std::max(0.0, std::abs(apart.dot(other.heading)) - other.length_m / 2);
  return std::hypot(along, cross(apart, other.heading));
}

}  // namespace mapless
