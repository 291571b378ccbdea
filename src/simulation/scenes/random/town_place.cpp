#include <algorithm>
#include <cmath>
#include <memory>

#include "simulation/scenes/random/draws.hpp"
#include "simulation/scenes/random/places.hpp"
#include "simulation/scenes/sensor_poses.hpp"
#include "simulation/scenes/town.hpp"
#include "simulation/traffic/agents.hpp"

namespace mapless::inline v1 {
namespace {

using Eigen::Vector2d;
using Kind = Carrier::Kind;

void draw_road_users(TownPlan& plan, RandomSequence& random) {
  const double km = plan.road_length_m() / 1000;
  const auto some = [&](double low, double high) {  // per kilometre of street
    return static_cast<int>(std::lround(km * random.uniform(low, high)));
  };
  plan.cars = 2 + some(3, 16);
  plan.vans = some(0, 4);
  plan.trucks = some(0, 3);
  plan.buses = some(0, 3);
  plan.motorcycles = some(0, 3);
  plan.cyclists = some(0, 7);
  plan.people = 4 + some(5, 60);
  plan.dogs = some(0, 5);
}

TownPlan draw_plan(RandomSequence& random, bool on_foot) {
  TownPlan plan;
  plan.nx = draw_count(random, 2, 3);
  plan.ny = draw_count(random, 2, 3);
  plan.dx_m = random.uniform(75, 170);
  plan.dy_m = random.uniform(75, 170);
  plan.lane_m = random.uniform(1.6, 2.3);
  // Room for parked cars (1.95 m) and for a bus in the lane (1.3 m from its middle).
  plan.half_road_m = plan.lane_m + 3.35 + random.uniform(0, 2.5);
  plan.pavement_m = random.uniform(on_foot ? 2.6 : 2.2, 5);
  plan.front_garden_m = random.uniform(1, 7);
  plan.fences = random.uniform(0, 1);
  plan.parked = random.uniform(0, 1);
  plan.speed = random.uniform(5, 17);
  plan.hills_m = random.uniform(0, 3);
  draw_road_users(plan, random);
  return plan;
}

// On the pavements; 0.6 m farther from the kerb and its trees than other walkers, who step aside by as much.
RoadUser walker_with_sensor(TownPlan plan, RandomSequence& random) {
  plan.half_road_m += 0.6;
  plan.pavement_m -= 0.6;
  return random_walker(plan, random, 2 * kMaxSceneDuration_s);
}

// At the corner of a junction.
RoadUser tripod_at_corner(const TownPlan& plan, RandomSequence& random) {
  const double corner = plan.half_road_m + plan.pavement_m / 2;
  const Vector2d at = plan.junction(random.index(plan.nx), random.index(plan.ny)) + Vector2d(corner, corner);
  RoadUser user;
  user.path = std::make_shared<Path>(std::vector<Vector2d>{at, at + Vector2d(2, 0)});
  return user;
}

double wheelbase_of(ObjectClass vehicle) {
  return vehicle == ObjectClass::bus     ? 8
         : vehicle == ObjectClass::truck ? 6.5
         : vehicle == ObjectClass::van   ? 3.2
                                         : 2.7;
}

constexpr double kCompanions_m = 15;  // largest distance along the way at time 0

// A start with no crossing near it: those who would start on a street are moved to its far side, all to one
// place.
double draw_start(const RoadUser& user, RandomSequence& random) {
  double start = 0;
  const auto crosses = [&](const StreetCrossing& c) {
    return c.to_m > start - kCompanions_m - 1 && c.from_m < start + kCompanions_m + 1;
  };
  for (int tries = 0; tries < 100; ++tries) {
    start = random.uniform(kCompanions_m, 400);
    if (std::none_of(user.crossings.begin(), user.crossings.end(), crosses)) break;
  }
  return start;
}

// Walkers on the way of the sensor, ahead of it and behind: they pass it closely.
void add_companions(std::vector<RoadUser>& users, RandomSequence& random) {
  const RoadUser first = users.front();
  const int count = draw_count(random, 0, 5);
  for (int k = 0; k < count; ++k) {
    RoadUser user = first;
    user.start_m = first.start_m + (k % 2 == 0 ? 1 : -1) * random.uniform(2, kCompanions_m);
    user.desired_speed = random.uniform(0.7, 1.8);
    users.push_back(std::move(user));
  }
}

}  // namespace

Place draw_town(SceneBuilder& scene, RandomSequence& random, const Carrier& carrier, std::uint64_t seed) {
  const TownPlan plan = draw_plan(random, carrier.on_foot());
  const double stop_every_s = random.uniform(9, 80);
  build_town(plan, Scenery(scene, plan.terrain(), seed), seed);
  SceneOptions options;
  options.seed = seed;
  auto users = town_people(plan, options, carrier.kind == Kind::vehicle);
  for (RoadUser& user : users) {
    if (on_foot(user.object_class)) user.stop_every_s = stop_every_s;
  }
  if (carrier.kind == Kind::vehicle) {
    users.front().wheelbase_m = wheelbase_of(carrier.vehicle);
  } else {
    RoadUser first;
    if (carrier.on_foot()) {
      first = walker_with_sensor(plan, random);
      first.wheelbase_m = 0.8;
    } else if (carrier.kind == Kind::drone) {
      first.path = random_drive(plan, random, 0, 12 * kMaxSceneDuration_s);
    } else {
      first = tripod_at_corner(plan, random);
    }
    first.object_class = carrier.on_foot() ? ObjectClass::person : ObjectClass::car;
    first.start_m = carrier.kind == Kind::tripod ? 0 : draw_start(first, random);
    users.insert(users.begin(), first);
    if (carrier.on_foot()) add_companions(users, random);
  }
  return {plan.terrain(), plan.junctions(), std::move(users)};
}

}  // namespace mapless
