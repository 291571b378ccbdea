#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "simulation/scenes/clearings.hpp"
#include "simulation/scenes/random/draws.hpp"
#include "simulation/scenes/random/places.hpp"
#include "simulation/scenes/rings.hpp"
#include "simulation/scenes/scenery.hpp"
#include "simulation/traffic/vehicles.hpp"

namespace mapless::inline v1 {
namespace {

using Eigen::Vector2d;

/// Lengths in metres; numbers of things per 100 m^2 of ground.
struct GroundsPlan {
  double half_m = 0;     ///< half the width of the ground
  double ceiling_m = 0;  ///< of a hall; 0: open
  double hills_m = 0, hill_m = 0;
  double trees = 0, bushes = 0, crates = 0, posts = 0, fences = 0;
  int rows = 0;      ///< of parked vehicles
  int shunters = 0;  ///< vehicles that start and stop
  int ways = 0, people = 0;
  double stop_every_s = 0;

  [[nodiscard]] Terrain terrain() const {
    return [height = hills_m, length = hill_m](double x, double y) {
      return height * std::sin(x / length + 0.5) * std::cos(y / (1.2 * length)) +
             0.1 * height * std::sin(x / 2.1) * std::sin(y / 2.3);
    };
  }
};

GroundsPlan draw_plan_of_grounds(RandomSequence& random) {
  GroundsPlan plan;
  const bool hall = random.chance(0.3);
  plan.half_m = hall ? random.uniform(18, 45) : random.uniform(35, 100);
  plan.ceiling_m = hall ? random.uniform(3.5, 9) : 0;
  plan.hills_m = hall || random.chance(0.3) ? 0 : random.uniform(0, 2);
  plan.hill_m = random.uniform(8, 30);
  const bool wood = !hall && random.chance(0.4);
  plan.trees = hall ? 0 : random.uniform(0, wood ? 4 : 0.4);
  plan.bushes = hall ? 0 : random.uniform(0, wood ? 2 : 0.4);
  plan.crates = random.uniform(0, wood ? 0.1 : 1);
  plan.posts = random.uniform(0, 0.2);
  plan.fences = random.uniform(0, 0.3);
  plan.rows = wood ? 0 : draw_count(random, 0, 12);
  plan.shunters = wood ? 0 : draw_count(random, 0, 8);
  plan.ways = draw_count(random, 2, 7);
  plan.people = draw_count(random, 5, 36);
  plan.stop_every_s = random.uniform(9, 80);
  return plan;
}

/// Puts things where nothing else is.
class Furnisher {
 public:
  Furnisher(const GroundsPlan& plan, const Scenery& scenery, RandomSequence& random)
      : plan_(plan), scenery_(scenery), random_(random), clearings_(plan.half_m) {}

  void keep_free(const RoadUser& user, double width) {
    const double once_round = std::min(user.path->length_m(), 500.0);
    for (double s = 0; s < once_round; s += 0.5)
      clearings_.take(user.path->at(std::fmod(user.start_m + s, user.path->length_m())), width);
  }
  void park_rows() {
    for (int k = 0; k < plan_.rows; ++k) {
      const Vector2d first = draw_position();
      const double angle = random_.uniform(0, kTurn);
      const bool abreast = random_.chance(0.6);
      const Vector2d step = abreast ? polar(2.6, angle + kTurn / 4) : polar(5.7, angle);
      for (int i = draw_count(random_, 2, 9); i > 0; --i) {
        const Vector2d at = first + i * step;
        const ObjectClass c = random_.chance(0.15) ? ObjectClass::van : ObjectClass::car;
        const int variant = random_.index(12);
        if (take_strip(at, angle, body_length(c), 2)) scenery_.put_parked(at, angle, c, variant);
      }
    }
  }
  /// A strip as long as the vehicle and its way; empty if there is no room for it.
  std::shared_ptr<const Path> draw_strip(double length) {
    const Vector2d at = draw_position();
    const double angle = random_.uniform(0, kTurn);
    if (!take_strip(at, angle, length, 2.4)) return nullptr;
    return std::make_shared<Path>(
        std::vector<Vector2d>{at - polar(length / 2, angle), at + polar(length / 2, angle)});
  }
  void scatter() {
    const double area = 4 * plan_.half_m * plan_.half_m / 100;
    const auto each = [&](double density, double room, const auto& put) {
      for (int k = static_cast<int>(area * density); k > 0; --k) {
        const Vector2d p = draw_position();
        const double angle = random_.uniform(0, kTurn);
        const int variant = random_.index(24);
        if (!clearings_.is_free(p)) continue;
        clearings_.take(p, room);
        put(p, variant, angle);
      }
    };
    each(plan_.crates, 2, [&](const Vector2d& p, int v, double a) { put_crate(p, v, a); });
    each(plan_.trees, 1, [&](const Vector2d& p, int v, double a) { scenery_.put_tree(p, v, a); });
    each(plan_.bushes, 1, [&](const Vector2d& p, int v, double a) { scenery_.put_bush(p, v, a); });
    each(plan_.posts, 0.5, [&](const Vector2d& p, int v, double a) {
      plan_.ceiling_m > 0 || v % 2 == 0 ? scenery_.put_sign(p, a) : scenery_.put_lamp(p, a);
    });
    for (int k = static_cast<int>(area * plan_.fences); k > 0; --k) {
      const Vector2d p = draw_position();
      const double angle = random_.uniform(0, kTurn);
      if (take_strip(p + polar(3, angle), angle, 6, 0.6)) scenery_.put_fence(p, angle, k % 2 == 0);
    }
  }

 private:
  [[nodiscard]] Vector2d draw_position() {
    const double reach = plan_.half_m - 4;
    const double x = random_.uniform(-reach, reach);
    return {x, random_.uniform(-reach, reach)};
  }
  // Takes a rectangle of ground that is wholly free; false otherwise.
  bool take_strip(const Vector2d& centre, double angle, double length, double width) {
    std::vector<Vector2d> points;
    for (double along = -length / 2; along <= length / 2; along += 0.4) {
      for (double aside = -width / 2; aside <= width / 2; aside += 0.4)
        points.push_back(centre + polar(along, angle) + polar(aside, angle + kTurn / 4));
    }
    const auto is_free = [&](const Vector2d& p) {
      return p.cwiseAbs().maxCoeff() < plan_.half_m - 1 && clearings_.is_free(p);
    };
    if (!std::all_of(points.begin(), points.end(), is_free)) return false;
    for (const Vector2d& p : points) clearings_.take(p, 0.3);
    return true;
  }
  // Stacks and shelves of up to 1.8 x 1.8 x 3 m.
  void put_crate(const Vector2d& p, int variant, double angle) const {
    SceneBuilder& scene = scenery_.scene();
    const auto shape = scene.shape(fmt::format("crate {}", variant), [&] {
      Mesh mesh;
      const double x = random_.uniform(0.2, 0.9);
      const double y = random_.uniform(0.2, 0.9);
      const Material m = draw_one<Material>(
          random_, {{Material::wood, 0.5}, {Material::metal, 0.3}, {Material::dark_paint, 0.2}});
      mesh.add_box({-x, -y, -0.4}, {x, y, random_.uniform(0.4, 3)}, m);
      return mesh;
    });
    scene.place(shape, SE3(rotation_z(angle), {p.x(), p.y(), scenery_.terrain()(p.x(), p.y())}),
                ObjectClass::furniture);
  }

  const GroundsPlan& plan_;
  const Scenery& scenery_;
  RandomSequence& random_;
  Clearings clearings_;
};

void build_shell(const GroundsPlan& plan, SceneBuilder& scene) {
  const double half = plan.half_m;
  scene.place(scene.shape("ground",
                          [&] {
                            const Vector2d reach = Vector2d::Constant(plan.ceiling_m > 0 ? half : half + 80);
                            return ground_patch(-reach, reach, 0, plan.hills_m > 0 ? 0.8 : 5, plan.terrain(),
                                                plan.ceiling_m > 0 ? Material::concrete : Material::earth);
                          }),
              SE3(), ObjectClass::ground);
  if (plan.ceiling_m <= 0) return;
  const auto shell = scene.shape("shell", [&] {
    Mesh mesh;
    mesh.add_box({-half, -half, -1}, {half, half, plan.ceiling_m}, Material::concrete);
    for (double x = -half + 6; x < half; x += 6)
      mesh.add_box({x, -half, plan.ceiling_m - 0.5}, {x + 0.3, half, plan.ceiling_m}, Material::metal);
    return mesh;
  });
  scene.place(shell, SE3(), ObjectClass::building);
}

std::vector<RoadUser> draw_walkers(const GroundsPlan& plan, RandomSequence& random) {
  struct Way {
    Vector2d centre;
    double radius, wave, phase;
  };
  std::vector<Way> ways;
  for (int k = 0; k < plan.ways; ++k) {
    const double reach = k == 0 ? 0 : 0.15 * plan.half_m;
    const double x = random.uniform(-reach, reach);
    const double radius = random.uniform(0.2, 0.65) * plan.half_m;
    ways.push_back({{x, random.uniform(-reach, reach)},
                    radius,
                    random.uniform(0.02, 0.07) * radius,
                    random.uniform(0, kTurn)});
  }
  std::vector<RoadUser> users;
  for (int k = 0; k <= plan.people; ++k) {
    // A third of them is on the way of the sensor.
    const Way& way = ways[k % 3 == 0 ? 0 : static_cast<std::size_t>(random.index(plan.ways))];
    RoadUser user;
    user.object_class = k % 8 == 7 ? ObjectClass::dog : ObjectClass::person;
    user.path = wavy_ring(way.centre, way.radius, way.wave, way.phase, 9 * kMaxSceneDuration_s,
                          k > 0 && random.chance(0.5));
    user.desired_speed = random.uniform(0.7, 1.9);
    user.wheelbase_m = 0.8;
    user.start_m = k == 0 ? 0 : random.uniform(2, kTurn * way.radius - 2);
    user.stop_every_s = k == 0 ? 0 : plan.stop_every_s;
    users.push_back(std::move(user));
  }
  return users;
}

/// Drives to and fro along the first `travel_m` of a path, and stands for some seconds at either end.
std::shared_ptr<const Track> shunt(std::shared_ptr<const Path> path, const Terrain& terrain, double from_m,
                                   double travel_m, RandomSequence& random, double duration_s) {
  auto track = std::make_shared<Track>(std::move(path), 2.7, terrain);
  double gone = 0;  // of the way to the other end
  double v = 0;
  bool back = false;
  double wait_s = random.uniform(0.5, 6);
  double fastest = random.uniform(0.4, 3);
  const double acceleration = random.uniform(0.4, 1.5);
  for (double t = 0; t <= duration_s + 1; t += Track::kStep_s) {
    track->add(from_m + (back ? travel_m - gone : gone), back ? -v : v);
    wait_s -= Track::kStep_s;
    if (wait_s > 0) continue;
    const double left = std::max(0.0, travel_m - gone);
    const double next =
        left < 0.02
            ? 0
            : std::min({v + acceleration * Track::kStep_s, fastest, std::sqrt(2 * acceleration * left)});
    gone += (v + next) / 2 * Track::kStep_s;
    v = next;
    if (v > 0 || left >= 0.02) continue;
    back = !back;
    gone = travel_m - gone;
    wait_s = random.uniform(1, 8);
    fastest = random.uniform(0.4, 3);
  }
  return track;
}

void add_shunters(const GroundsPlan& plan, SceneBuilder& scene, Furnisher& furnisher, std::uint64_t seed,
                  double duration_s) {
  for (std::uint64_t k = 0; k < static_cast<std::uint64_t>(plan.shunters); ++k) {
    RandomSequence random(seed, 7200 + k);
    const auto c = draw_one<ObjectClass>(
        random, {{ObjectClass::car, 0.6}, {ObjectClass::van, 0.25}, {ObjectClass::truck, 0.15}});
    if (plan.ceiling_m > 0 && c == ObjectClass::truck && plan.ceiling_m < 4.5) continue;
    const int variant = random.index(12);
    const double travel = random.uniform(1.5, 12);
    const auto strip = furnisher.draw_strip(body_length(c) + travel + 0.6);
    if (strip == nullptr) continue;
    const double from = body_length(c) / 2 + 0.3;
    add_vehicle(scene, c, variant, shunt(strip, plan.terrain(), from, travel, random, duration_s));
  }
}

}  // namespace

Place draw_grounds(SceneBuilder& scene, RandomSequence& random, const Carrier& carrier, std::uint64_t seed,
                   double duration_s) {
  GroundsPlan plan = draw_plan_of_grounds(random);
  if (carrier.kind == Carrier::Kind::drone) plan.ceiling_m = 0;
  build_shell(plan, scene);
  std::vector<RoadUser> users = draw_walkers(plan, random);
  const Scenery scenery(scene, plan.terrain(), seed);
  Furnisher furnisher(plan, scenery, random);
  for (const RoadUser& user : users) furnisher.keep_free(user, &user == &users.front() ? 1.6 : 1.2);
  furnisher.park_rows();
  add_shunters(plan, scene, furnisher, seed, duration_s);
  furnisher.scatter();
  return {plan.terrain(), {}, std::move(users)};
}

}  // namespace mapless
