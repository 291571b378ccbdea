#include <cmath>
#include <memory>
#include <numbers>

#include "simulation/scenes/random/draws.hpp"
#include "simulation/scenes/random/places.hpp"
#include "simulation/scenes/rings.hpp"
#include "simulation/scenes/scenery.hpp"
#include "simulation/traffic/agents.hpp"

namespace mapless::inline v1 {
namespace {

using Eigen::Vector2d;
using Kind = Carrier::Kind;

/// One road round a ring about the origin. Lengths in metres; shares from 0 to 1.
struct RoadPlan {
  double radius_m = 0;     ///< of its centre line
  int lanes = 1;           ///< each way
  double lane_m = 0;       ///< from the centre line to the middle of the first lane
  double half_road_m = 0;  ///< from the centre line to the kerb
  double pavement_m = 0, garden_m = 0;
  double speed_mps = 0;
  double least_gap_m = 0, most_gap_m = 0;  ///< between vehicles at time 0
  bool lights = false;                     ///< four traffic lights
  bool rails = false;                      ///< along the kerbs, in place of pavements and people
  double houses = 0, trees = 0, fences = 0, parked = 0;
  int people = 0;
  double stop_every_s = 0;
  double hills_m = 0;

  static constexpr double kLaneWidth_m = 3.6;
  [[nodiscard]] Terrain terrain() const {
    return [height = hills_m](double x, double y) { return height * std::sin(x / 60) * std::cos(y / 70); };
  }
};

RoadPlan draw_plan_of_road(RandomSequence& random, bool on_foot) {
  RoadPlan plan;
  const bool fast = !on_foot && random.chance(0.45);
  plan.radius_m = fast ? random.uniform(250, 700) : random.uniform(60, 250);
  plan.lanes = fast ? draw_count(random, 1, 2) : 1;
  plan.lane_m = random.uniform(1.6, 2.3) + (fast ? 0.3 : 0);
  plan.half_road_m =
      plan.lane_m + (plan.lanes - 1) * RoadPlan::kLaneWidth_m + 3.4 + random.uniform(0, fast ? 3 : 1);
  plan.pavement_m = random.uniform(2.4, 5);
  plan.garden_m = random.uniform(0.6, fast ? 30 : 7);
  plan.speed_mps = fast ? random.uniform(14, 31) : random.uniform(4, 14);
  plan.least_gap_m = random.uniform(25, 40);
  plan.most_gap_m = plan.least_gap_m + random.uniform(10, 180);
  plan.lights = !fast && random.chance(0.6);
  plan.rails = fast && random.chance(0.6);
  plan.houses = random.uniform(0, fast ? 0.3 : 1);
  plan.trees = random.uniform(0, 0.7);
  plan.fences = random.uniform(0, 1);
  plan.parked = fast ? 0 : random.uniform(0, 1);
  plan.people = plan.rails ? 0 : draw_count(random, 6, 50);
  plan.stop_every_s = random.uniform(9, 80);
  plan.hills_m = random.uniform(0, 2.5);
  return plan;
}

// Things beside the road on one side (1: outside the ring, -1: inside), metre by metre along it.
class Roadside {
 public:
  Roadside(const RoadPlan& plan, const Scenery& scenery, double side, std::uint64_t seed)
      : plan_(plan), scenery_(scenery), side_(side), random_(seed, side > 0 ? 7100 : 7101) {}

  void build() {
    for (double along = 0; along < kTurn * plan_.radius_m - 8; along += 6.2) {
      put_at_kerb(along);
      put_behind(along);
    }
    const double line = plan_.half_road_m + plan_.pavement_m + plan_.garden_m;
    for (double along = 4; along < kTurn * plan_.radius_m - 18;) {
      const int variant = random_.index(12);
      const double width = Scenery::house_width(variant);
      if (random_.chance(plan_.houses)) {
        scenery_.put_house(at(along + width / 2, line + random_.uniform(0, 2)), angle(along + width / 2),
                           variant);
      } else if (random_.chance(plan_.trees)) {
        scenery_.put_tree(at(along + 3, line + random_.uniform(2, 12)), random_.index(6), along);
      }
      along += width + random_.uniform(0.5, 9);
    }
  }

 private:
  // `out` metres from the centre line.
  [[nodiscard]] Vector2d at(double along, double out) const {
    return polar(plan_.radius_m + side_ * out, along / plan_.radius_m);
  }
  // Of a thing whose y axis points away from the road.
  [[nodiscard]] double angle(double along) const {
    return along / plan_.radius_m - side_ * std::numbers::pi / 2;
  }

  void put_at_kerb(double along) {
    const double kerb = plan_.half_road_m;
    if (plan_.rails) {
      scenery_.put_fence(at(along, kerb + 0.3), angle(along), true);
    } else if (random_.chance(plan_.parked)) {
      scenery_.put_parked(at(along + random_.uniform(0, 0.8), kerb - 0.97), angle(along),
                          random_.chance(0.15) ? ObjectClass::van : ObjectClass::car, random_.index(12));
    }
    if (random_.chance(0.15)) scenery_.put_lamp(at(along, kerb + 0.4), angle(along));
    if (random_.chance(0.08)) scenery_.put_sign(at(along + 2, kerb + 0.4), angle(along));
  }

  void put_behind(double along) {
    const double line = plan_.half_road_m + plan_.pavement_m;
    if (random_.chance(plan_.fences)) scenery_.put_fence(at(along, line + 0.2), angle(along), false);
    if (random_.chance(0.5 * plan_.trees))
      scenery_.put_bush(at(along, line + 1.5), random_.index(4), random_.uniform(0, 6));
  }

  const RoadPlan& plan_;
  const Scenery& scenery_;
  double side_;
  RandomSequence random_;
};

ObjectClass draw_vehicle(RandomSequence& random) {
  return draw_one<ObjectClass>(random, {{ObjectClass::car, 0.6},
                                        {ObjectClass::van, 0.14},
                                        {ObjectClass::truck, 0.1},
                                        {ObjectClass::bus, 0.08},
                                        {ObjectClass::motorcycle, 0.08}});
}

void add_vehicles(const RoadPlan& plan, RandomSequence& random, std::vector<RoadUser>& users) {
  for (int l = 0; l < 2 * plan.lanes; ++l) {
    const bool oncoming = l % 2 == 1;
    const int lane = l / 2;  // of its direction, from the middle
    const double out = plan.lane_m + lane * RoadPlan::kLaneWidth_m;
    const double radius = plan.radius_m + (oncoming ? -out : out);
    const double speed = plan.speed_mps * (lane == 0 ? 1.0 : 0.8);
    const auto path = wavy_ring({0, 0}, radius, 0, 0, 34 * kMaxSceneDuration_s, oncoming);
    for (double start = 20; start < kTurn * radius - plan.least_gap_m;) {
      RoadUser user;
      user.object_class = draw_vehicle(random);
      user.path = path;
      user.start_m = start;
      user.desired_speed = speed * random.uniform(0.9, 1.1);
      users.push_back(std::move(user));
      start += random.uniform(plan.least_gap_m, plan.most_gap_m);
    }
  }
}

void add_people(const RoadPlan& plan, RandomSequence& random, std::vector<RoadUser>& users) {
  for (int k = 0; k < plan.people; ++k) {
    const double side = random.chance(0.5) ? 1 : -1;
    const double out = plan.half_road_m + random.uniform(1.2, plan.pavement_m - 0.5);
    RoadUser user;
    user.object_class = random.chance(0.1) ? ObjectClass::dog : ObjectClass::person;
    user.path = wavy_ring({0, 0}, plan.radius_m + side * out, 0, random.uniform(0, kTurn),
                          2 * kMaxSceneDuration_s, random.chance(0.5));
    user.desired_speed = random.uniform(0.8, 1.8);
    user.wheelbase_m = 0.8;
    user.stop_every_s = plan.stop_every_s;
    users.push_back(std::move(user));
  }
}

// The user with the sensor, unless it is one of the vehicles.
RoadUser user_with_sensor(const RoadPlan& plan, const Carrier& carrier, RandomSequence& random) {
  const double kerb = plan.half_road_m;
  const double out = carrier.on_foot()             ? kerb + random.uniform(1.3, plan.pavement_m - 0.6)
                     : carrier.kind == Kind::drone ? 0.0
                                                   : kerb + 0.5 * plan.pavement_m;
  RoadUser user;
  user.object_class = carrier.on_foot() ? ObjectClass::person : ObjectClass::car;
  user.path =
      wavy_ring({0, 0}, plan.radius_m + out, 0, random.uniform(0, kTurn), 9 * kMaxSceneDuration_s, false);
  if (carrier.on_foot()) user.wheelbase_m = 0.8;
  return user;
}

std::vector<Junction> lights_of(const RoadPlan& plan) {
  std::vector<Junction> out;
  for (int k = 0; plan.lights && k < 4; ++k)
    out.push_back({polar(plan.radius_m, kTurn * k / 4), plan.half_road_m + 1, 9.0 * k});
  return out;
}

}  // namespace

Place draw_road(SceneBuilder& scene, RandomSequence& random, const Carrier& carrier, std::uint64_t seed) {
  const RoadPlan plan = draw_plan_of_road(random, carrier.on_foot());
  const Material surface = draw_one<Material>(random, {{Material::asphalt, 0.7}, {Material::earth, 0.3}});
  scene.place(scene.shape("ground",
                          [&] {
                            const Vector2d half = Vector2d::Constant(plan.radius_m + 130);
                            return ground_patch(-half, half, 0, 5, plan.terrain(), surface);
                          }),
              SE3(), ObjectClass::ground);
  const Scenery scenery(scene, plan.terrain(), seed);
  for (const double side : {1.0, -1.0}) Roadside(plan, scenery, side, seed).build();
  std::vector<RoadUser> users;
  if (carrier.kind != Kind::vehicle) users.push_back(user_with_sensor(plan, carrier, random));
  add_vehicles(plan, random, users);
  add_people(plan, random, users);
  return {plan.terrain(), lights_of(plan), std::move(users)};
}

}  // namespace mapless
