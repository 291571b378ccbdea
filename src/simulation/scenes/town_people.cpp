#include <algorithm>
#include <array>
#include <cmath>

#include "simulation/scenes/town.hpp"

namespace mapless::inline v1 {
namespace {

using Eigen::Vector2d;

const std::array<Vector2d, 4> kDirections = {{{1, 0}, {0, 1}, {-1, 0}, {0, -1}}};

struct Crossing {
  int i, j;
};

Crossing next(Crossing at, int direction) {
  const Vector2d& d = kDirections[static_cast<std::size_t>(direction)];
  return {at.i + static_cast<int>(d.x()), at.j + static_cast<int>(d.y())};
}

bool is_in(const TownPlan& plan, Crossing c) {
  return c.i >= 0 && c.j >= 0 && c.i < plan.nx && c.j < plan.ny;
}

// A quadratic Bezier curve from the last of `points` to b, in the directions they are met.
void add_turn(std::vector<Vector2d>& points, const Vector2d& along_a, const Vector2d& b,
              const Vector2d& along_b) {
  const Vector2d a = points.back();  // a copy: the points move as they grow
  const double cross = along_a.x() * along_b.y() - along_a.y() * along_b.x();
  if (std::abs(cross) < 0.1) return;  // straight on
  const Vector2d apart = b - a;
  const Vector2d corner = a + along_a * ((apart.x() * along_b.y() - apart.y() * along_b.x()) / cross);
  for (int k = 1; k < 12; ++k) {
    const double u = k / 12.0;
    points.emplace_back((1 - u) * (1 - u) * a + 2 * u * (1 - u) * corner + u * u * b);
  }
}

int choose_turn(const TownPlan& plan, RandomSequence& random, Crossing at, int direction) {
  std::vector<int> open;
  for (const int turn : {0, 1, 3}) {
    const int d = (direction + turn) % 4;
    if (is_in(plan, next(at, d))) open.push_back(d);
  }
  if (open.empty()) return (direction + 2) % 4;
  return open[static_cast<std::size_t>(random.index(static_cast<int>(open.size())))];
}

struct Share {
  ObjectClass object_class;
  int count;
  double aside_m;
  double speed;
  double wheelbase_m;
};

// Whether a vehicle may begin here: not on a junction, and not in another one.
bool is_free(const TownPlan& plan, const std::vector<RoadUser>& users, const RoadUser& user) {
  constexpr double kRoom = 16;
  const Vector2d p = user.path->at(user.start_m);
  const Vector2d heading = user.path->heading(user.start_m, 2);
  for (const Junction& junction : plan.junctions()) {
    if ((p - junction.centre).cwiseAbs().maxCoeff() < junction.half_size_m + kRoom / 2) return false;
  }
  return std::none_of(users.begin(), users.end(), [&](const RoadUser& other) {
    return (other.path->at(other.start_m) - p).norm() < kRoom &&
           other.path->heading(other.start_m, 2).dot(heading) > 0;
  });
}

}  // namespace

std::shared_ptr<const Path> random_drive(const TownPlan& plan, RandomSequence& random, double aside_m,
                                         double length_m) {
  Crossing at{random.index(plan.nx), random.index(plan.ny)};
  int direction = choose_turn(plan, random, at, random.index(4));
  const double box = plan.turn_m();
  std::vector<Vector2d> points;
  double length = 0;
  Vector2d before = Vector2d::Zero();
  while (length < length_m) {
    const Vector2d& along = kDirections[static_cast<std::size_t>(direction)];
    const Vector2d right(along.y(), -along.x());
    const Vector2d from = plan.junction(at.i, at.j) + along * box + right * aside_m;
    at = next(at, direction);
    const Vector2d to = plan.junction(at.i, at.j) - along * box + right * aside_m;
    if (!points.empty()) add_turn(points, before, from, along);
    points.push_back(from);
    points.push_back(to);
    length += (to - from).norm() + 2 * box;
    before = along;
    direction = choose_turn(plan, random, at, direction);
  }
  return std::make_shared<Path>(points);
}

RoadUser random_walker(const TownPlan& plan, RandomSequence& random, double length_m) {
  // Corners of the pavements lie about the junctions; a walk goes from corner to corner, along a street or
  // across one.
  const double corner = plan.half_road_m + random.uniform(1.4, plan.pavement_m - 0.5);
  Crossing at{random.index(plan.nx), random.index(plan.ny)};
  Vector2d side(random.chance(0.5) ? 1 : -1, random.chance(0.5) ? 1 : -1);
  std::vector<Vector2d> points = {plan.junction(at.i, at.j) + corner * side};
  RoadUser walker;
  double length = 0;
  while (length < length_m) {
    const int axis = random.index(2);
    const double towards = side[axis];
    const int direction = axis == 0 ? (towards > 0 ? 0 : 2) : (towards > 0 ? 1 : 3);
    const bool across = random.chance(0.3) || !is_in(plan, next(at, direction));
    const Crossing then = across ? at : next(at, direction);
    side[axis] = -side[axis];
    const Vector2d to = plan.junction(then.i, then.j) + corner * side;
    if (points.size() > 1 && (to - points[points.size() - 2]).norm() < 1) {  // back where he came from
      side[axis] = -side[axis];
      continue;
    }
    at = then;
    const double kerb = length + corner - plan.half_road_m;
    if (across)
      walker.crossings.push_back(
          {kerb, kerb + 2 * plan.half_road_m, plan.junction_number(at.i, at.j), axis == 0});
    length += (to - points.back()).norm();
    points.push_back(to);
  }
  walker.path = std::make_shared<Path>(points);
  return walker;
}

std::vector<RoadUser> town_people(const TownPlan& plan, const SceneOptions& options, bool with_ego) {
  std::vector<RoadUser> users;
  const double reach = plan.speed * 1.3 * kMaxSceneDuration_s;
  std::uint64_t number = 0;
  const auto ego_count = with_ego ? 1 : 0;
  const std::array<Share, 7> shares = {
      {{ObjectClass::car, ego_count, plan.lane_m, plan.speed, 2.7},
       {ObjectClass::bus, plan.buses, plan.lane_m, 0.85 * plan.speed, 8},
       {ObjectClass::truck, plan.trucks, plan.lane_m, 0.85 * plan.speed, 6.5},
       {ObjectClass::van, plan.vans, plan.lane_m, plan.speed, 3.2},
       {ObjectClass::car, plan.cars, plan.lane_m, plan.speed, 2.7},
       {ObjectClass::motorcycle, plan.motorcycles, plan.lane_m, plan.speed, 1.4},
       {ObjectClass::cyclist, plan.cyclists, plan.lane_m + 0.8, 5, 1.2}}};
  for (const Share& share : shares) {
    for (int k = 0; k < share.count; ++k) {
      RandomSequence random(options.seed, 3000 + number++);
      RoadUser user;
      user.object_class = share.object_class;
      user.path = random_drive(plan, random, share.aside_m, reach);
      user.desired_speed = share.speed * random.uniform(0.85, 1.1);
      user.wheelbase_m = share.wheelbase_m;
      for (int tries = 0; tries == 0 || (tries < 200 && !is_free(plan, users, user)); ++tries)
        user.start_m = random.uniform(10, 900);
      users.push_back(std::move(user));
    }
  }
  for (int k = 0; k < plan.people + plan.dogs; ++k) {
    RandomSequence random(options.seed, 5000 + number++);
    RoadUser user = random_walker(plan, random, 2 * kMaxSceneDuration_s);
    user.object_class = k < plan.people ? ObjectClass::person : ObjectClass::dog;
    user.desired_speed = random.uniform(0.9, 1.7);
    user.wheelbase_m = 0.8;
    user.start_m = random.uniform(0, 250);
    user.stop_every_s = 40;
    users.push_back(std::move(user));
  }
  return users;
}

}  // namespace mapless
