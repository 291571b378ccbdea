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
constexpr double kHalfWidth = 3.6;

Terrain floor_of_tunnel() {
  return [](double x, double /*y*/) { return 0.8 * std::sin(x / 30); };
}

// The middle of the tunnel swings to the sides, so that its ends are out of sight.
double middle(double x) { return 6 * std::sin(x / 28); }

// Around the arch from the right foot to the left, as (across, up).
Vector2d arch(double u) {
  const double a = u * std::numbers::pi;
  return {-kHalfWidth * std::cos(a), 1.2 + 3.2 * std::sin(a)};
}

Mesh tube() {
  Mesh mesh;
  constexpr int kAround = 14;
  const auto ring_of = [](double x, int k) {
    const double z = floor_of_tunnel()(x, 0);
    if (k < 0) return Vector3d(x, middle(x) - kHalfWidth, z);
    if (k > kAround) return Vector3d(x, middle(x) + kHalfWidth, z);
    const Vector2d p = arch(static_cast<double>(k) / kAround);
    return Vector3d(x, middle(x) + p.x(), z + p.y());
  };
  for (double x = -kHalfLength; x < kHalfLength; x += 1) {
    for (int k = -1; k <= kAround; ++k)
      mesh.add_quad(ring_of(x, k), ring_of(x + 1, k), ring_of(x + 1, k + 1), ring_of(x, k + 1),
                    Material::concrete);
    mesh.add_quad(ring_of(x, -1), ring_of(x + 1, -1), ring_of(x + 1, kAround + 1), ring_of(x, kAround + 1),
                  Material::asphalt);
  }
  for (const double x : {-kHalfLength, kHalfLength}) {
    mesh.add_quad({x, middle(x) - 4, -2}, {x, middle(x) + 4, -2}, {x, middle(x) + 4, 6},
                  {x, middle(x) - 4, 6}, Material::concrete);
  }
  return mesh;
}

// Ribs, pipes, lamps and boxes, without which every place would look the same.
Mesh fittings(std::uint64_t seed) {
  Mesh mesh;
  RandomSequence random(seed, 2400);
  for (double x = -kHalfLength + 2; x < kHalfLength - 2; x += 4) {
    const double z = floor_of_tunnel()(x, 0);
    const double y = middle(x);
    for (const double side : {-1.0, 1.0})
      mesh.add_frustum({x, y + side * (kHalfWidth - 0.1), z}, 0.12, {x, y + side * (kHalfWidth - 0.1), z + 2},
                       0.12, 6, Material::metal);
    const double after = x + 4;
    mesh.add_frustum({x, y + 2.9, z + 2.5}, 0.1,
                     {after, middle(after) + 2.9, floor_of_tunnel()(after, 0) + 2.5}, 0.1, 8,
                     Material::metal);
    if (random.chance(0.4)) {
      const double side = random.chance(0.5) ? -3.4 : 2.9;
      mesh.add_box({x + 1, y + side, z - 0.2},
                   {x + 1 + random.uniform(0.4, 1.5), y + side + 0.6, z + random.uniform(0.5, 1.8)},
                   Material::wood);
    }
    if (random.chance(0.5)) mesh.add_box({x, y - 0.1, z + 4.1}, {x + 1.2, y + 0.1, z + 4.3}, Material::metal);
  }
  return mesh;
}

// Up one side of the tunnel and down the other, for any duration.
std::shared_ptr<const Path> up_and_down(double aside, double turn_at, bool backwards) {
  std::vector<Vector2d> points;
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

SE3 hand_held(const Track& track, double t) {
  const double steps = kTurn * track.distance_m(t) / 0.7;
  const Vector3d shake(0.25 * std::sin(1.9 * t) + 0.03 * std::sin(steps), 0.22 * std::sin(2.6 * t + 1),
                       0.9 * std::sin(1.3 * t) + 0.35 * std::sin(3.1 * t));
  const SE3 hand(so3_exp(shake), {0.3, -0.1 + 0.05 * std::sin(steps / 2), 1.45 + 0.04 * std::sin(steps)});
  return track.pose(t) * hand;
}

}  // namespace

Scene tunnel(const SceneOptions& options) {
  SceneBuilder builder;
  builder.place(builder.shape("tube", tube), SE3(), ObjectClass::building);
  builder.place(builder.shape("fittings", [&] { return fittings(options.seed); }), SE3(),
                ObjectClass::furniture);
  std::vector<RoadUser> users;
  for (std::size_t k = 0; k < 22; ++k) {
    RandomSequence random(options.seed, 3400 + k);
    RoadUser user;
    user.object_class = k % 8 == 7 ? ObjectClass::dog : ObjectClass::person;
    user.path =
        up_and_down(k == 0 ? 0.5 : random.uniform(1.0, 2.4), random.uniform(70, 95), k != 0 && k % 2 == 0);
    user.desired_speed = random.uniform(0.9, 1.6);
    user.wheelbase_m = 0.8;
    user.start_m = k == 0 ? 60 : random.uniform(0, 160);
    user.stop_every_s = k == 0 ? 0 : 40;
    users.push_back(std::move(user));
  }
  const auto tracks = drive_all(users, {}, floor_of_tunnel(), options.duration_s + kMargin_s, options.seed);
  add_movers(builder, users, tracks, 1);
  Scene scene;
  scene.poses = sample_poses([&](double t) { return hand_held(*tracks.front(), t); }, options.duration_s);
  scene.world = builder.take();
  return scene;
}

}  // namespace mapless
