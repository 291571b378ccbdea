#include <algorithm>
#include <cmath>

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

// On the top of a hill, so that the ground falls away and the sky begins below the horizon.
Terrain hill_top() {
  return
      [](double x, double y) { return -0.0022 * (x * x + y * y) + 0.1 * std::sin(x / 3) * std::sin(y / 4); };
}

void add_flyers(SceneBuilder& scene, std::uint64_t seed) {
  for (std::uint64_t k = 0; k < 10; ++k) {
    RandomSequence random(seed, 3300 + k);
    const double radius = random.uniform(9, 38);
    const double height = random.uniform(1.8, 2.6 + 0.06 * radius);
    const double speed = (k % 2 == 0 ? 1 : -1) * random.uniform(4, 9) / radius;
    const double phase = random.uniform(0, kTurn);
    const auto T_0b = [=](Time t) {
      const double a = phase + speed * t.seconds();
      const Vector2d p = polar(radius * (1 + 0.2 * std::sin(0.31 * t.seconds() + phase)), a);
      const double z = height + 0.5 * std::sin(0.7 * t.seconds() + phase);
      return SE3(rotation_z(a + (speed > 0 ? kTurn / 4 : -kTurn / 4)), {p.x(), p.y(), z});
    };
    if (k < 6) {
      add_bird(scene, T_0b, random.uniform(2, 4));
    } else if (k < 8) {
      add_drone(scene, T_0b);
    } else {
      // A ball thrown up again and again: a parabola of period T.
      add_ball(
          scene,
          [=](Time t) {
            SE3 pose = T_0b(t);
            const double period = 1.4;
            const double u = std::remainder(t.seconds() + phase, period);
            const Vector3d p(pose.translation().x(), pose.translation().y(),
                             1 + 9.81 / 2 * (period * period / 4 - u * u));
            return SE3(pose.rotation(), p);
          },
          k == 8 ? 0.12 : 0.35);
    }
  }
}

}  // namespace

Scene flyer(const SceneOptions& options) {
  SceneBuilder builder;
  const auto ground = builder.shape("ground", [] {
    return ground_patch({-150, -150}, {150, 150}, 0, 1.5, hill_top(), Material::earth);
  });
  builder.place(ground, SE3(), ObjectClass::ground);
  const Scenery scenery(builder, hill_top(), options.seed);
  RandomSequence random(options.seed, 2300);
  for (int k = 0; k < 14; ++k)
    scenery.put_bush(polar(random.uniform(8, 45), random.uniform(0, kTurn)), k, random.uniform(0, kTurn));
  add_flyers(builder, options.seed);
  const auto path = wavy_ring({0, 0}, 6, 0.5, 0, 2 * kMaxSceneDuration_s, false);
  RoadUser walker{ObjectClass::person, path, 0, 1.1, 0.8, 0};
  const auto tracks = drive_all({walker}, {}, hill_top(), options.duration_s + kMargin_s, options.seed);
  Scene scene;
  scene.poses = sample_poses([&](double t) { return carried(*tracks.front(), 1.9, t); }, options.duration_s);
  scene.world = builder.take();
  return scene;
}

}  // namespace mapless
