#include "simulation/scenes/tunnel_scene.hpp"

#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

#include "simulation/scenes/named_scenes.hpp"
#include "simulation/scenes/rings.hpp"
#include "simulation/scenes/scenery.hpp"
#include "simulation/scenes/sensor_poses.hpp"
#include "simulation/traffic/bodies.hpp"
#include "simulation/traffic/living.hpp"
#include "simulation/traffic/traffic.hpp"

namespace mapless::inline v1 {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kHalfLength = 110;  // of the tunnel, along x [m]

// Around the arch from the right foot to the left, as (across, up).
Vector2d arch(const TunnelPlan& plan, double u) {
  const double a = u * std::numbers::pi;
  return {-plan.half_width_m * std::cos(a), 1.2 + (plan.height_m - 1.2) * std::sin(a)};
}

Mesh tube(const TunnelPlan& plan) {
  Mesh mesh;
  constexpr int kAround = 14;
  const auto middle = [&](double x) { return plan.middle(x); };
  const auto ring_of = [&](double x, int k) {
    const double z = plan.terrain()(x, 0);
    if (k < 0) return Vector3d(x, middle(x) - plan.half_width_m, z);
    if (k > kAround) return Vector3d(x, middle(x) + plan.half_width_m, z);
    const Vector2d p = arch(plan, static_cast<double>(k) / kAround);
    return Vector3d(x, middle(x) + p.x(), z + p.y());
  };
  for (double x = -kHalfLength; x < kHalfLength; x += 1) {
    for (int k = -1; k <= kAround; ++k)
      mesh.add_quad(ring_of(x, k), ring_of(x + 1, k), ring_of(x + 1, k + 1), ring_of(x, k + 1),
                    Material::concrete);
    mesh.add_quad(ring_of(x, -1), ring_of(x + 1, -1), ring_of(x + 1, kAround + 1), ring_of(x, kAround + 1),
                  Material::asphalt);
  }
  const double end = plan.half_width_m + 0.4;
  for (const double x : {-kHalfLength, kHalfLength}) {
    mesh.add_quad({x, middle(x) - end, -2}, {x, middle(x) + end, -2}, {x, middle(x) + end, 6},
                  {x, middle(x) - end, 6}, Material::concrete);
  }
  return mesh;
}

// Ribs, pipes, lamps and boxes, without which every place would look the same.
Mesh fittings(const TunnelPlan& plan, std::uint64_t seed) {
  Mesh mesh;
  RandomSequence random(seed, 2400);
  const double left = plan.half_width_m - 0.7;
  const double right = plan.half_width_m - 0.2;
  for (double x = -kHalfLength + 2; x < kHalfLength - 2; x += 4) {
    const double z = plan.terrain()(x, 0);
    const double y = plan.middle(x);
    for (const double side : {-1.0, 1.0}) {
      const double wall = y + side * (plan.half_width_m - 0.1);
      mesh.add_frustum({x, wall, z}, 0.12, {x, wall, z + 2}, 0.12, 6, Material::metal);
    }
    const double after = x + 4;
    mesh.add_frustum({x, y + left, z + 2.5}, 0.1,
                     {after, plan.middle(after) + left, plan.terrain()(after, 0) + 2.5}, 0.1, 8,
                     Material::metal);
    if (random.chance(plan.boxes)) {
      const double side = random.chance(0.5) ? -right : left;
      mesh.add_box({x + 1, y + side, z - 0.2},
                   {x + 1 + random.uniform(0.4, 1.5), y + side + 0.6, z + random.uniform(0.5, 1.8)},
                   Material::wood);
    }
    const double lamp = z + plan.height_m - 0.3;
    if (random.chance(0.5)) mesh.add_box({x, y - 0.1, lamp}, {x + 1.2, y + 0.1, lamp + 0.2}, Material::metal);
  }
  return mesh;
}

// Up one side of the tunnel and down the other, for any duration.
std::shared_ptr<const Path> up_and_down(const TunnelPlan& plan, double aside, double turn_at,
                                        bool backwards) {
  std::vector<Vector2d> points;
  const auto middle = [&](double x) { return plan.middle(x); };
  for (int lap = 0; lap < 8; ++lap) {
    for (double x = -turn_at; x < turn_at; x += 2) points.emplace_back(x, middle(x) - aside);
    for (double a = 0; a < std::numbers::pi; a += 0.4)
      points.emplace_back(turn_at + aside * std::sin(a), middle(turn_at) - aside * std::cos(a));
    for (double x = turn_at; x > -turn_at; x -= 2) points.emplace_back(x, middle(x) + aside);
    for (double a = 0; a < std::numbers::pi; a += 0.4)
      points.emplace_back(-turn_at - aside * std::sin(a), middle(-turn_at) + aside * std::cos(a));
  }
  if (backwards) points = {points.rbegin(), points.rend()};
  return std::make_shared<Path>(points);
}

}  // namespace

Terrain TunnelPlan::terrain() const {
  return [height = hills_m](double x, double /*y*/) { return height * std::sin(x / 30); };
}

double TunnelPlan::middle(double x) const { return swing_m * std::sin(x / 28); }

void build_tunnel(const TunnelPlan& plan, SceneBuilder& scene, std::uint64_t seed) {
  scene.place(scene.shape("tube", [&] { return tube(plan); }), SE3(), ObjectClass::building);
  scene.place(scene.shape("fittings", [&] { return fittings(plan, seed); }), SE3(), ObjectClass::furniture);
}

std::vector<RoadUser> tunnel_people(const TunnelPlan& plan, std::uint64_t seed) {
  std::vector<RoadUser> users;
  for (std::size_t k = 0; k <= static_cast<std::size_t>(plan.people); ++k) {
    RandomSequence random(seed, 3400 + k);
    RoadUser user;
    user.object_class = k % 8 == 7 ? ObjectClass::dog : ObjectClass::person;
    user.path =
        up_and_down(plan, k == 0 ? plan.sensor_way_m : random.uniform(plan.first_way_m, plan.last_way_m),
                    random.uniform(70, 95), k != 0 && k % 2 == 0);
    user.desired_speed = random.uniform(0.9, 1.6);
    user.wheelbase_m = 0.8;
    user.start_m = k == 0 ? 60 : random.uniform(0, 160);
    user.stop_every_s = k == 0 ? 0 : plan.stop_every_s;
    users.push_back(std::move(user));
  }
  return users;
}

Scene tunnel(const SceneOptions& options) {
  const TunnelPlan plan;
  SceneBuilder builder;
  build_tunnel(plan, builder, options.seed);
  const auto users = tunnel_people(plan, options.seed);
  const auto tracks = drive_all(users, {}, plan.terrain(), options.duration_s + kMargin_s, options.seed);
  add_movers(builder, users, tracks, 1);
  Scene scene;
  scene.poses = sample_poses([&](double t) { return hand_held(*tracks.front(), 1, t); }, options.duration_s);
  scene.world = builder.take();
  return scene;
}

}  // namespace mapless
