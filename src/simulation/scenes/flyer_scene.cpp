#include "simulation/scenes/flyer_scene.hpp"

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

// Six in ten are birds, two drones, two balls.
void add_flyers(SceneBuilder& scene, std::uint64_t seed, int count) {
  for (std::uint64_t k = 0; k < static_cast<std::uint64_t>(count); ++k) {
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
    if (k % 10 < 6) {
      add_bird(scene, T_0b, random.uniform(2, 4));
    } else if (k % 10 < 8) {
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
          k % 10 == 8 ? 0.12 : 0.35);
    }
  }
}

}  // namespace

// The ground falls away, and the sky begins below the horizon.
Terrain HillPlan::terrain() const {
  return [fall = fall_per_m](double x, double y) {
    return -fall * (x * x + y * y) + 0.1 * std::sin(x / 3) * std::sin(y / 4);
  };
}

void build_hill(const HillPlan& plan, SceneBuilder& scene, std::uint64_t seed) {
  const auto ground = scene.shape("ground", [&] {
    return ground_patch({-150, -150}, {150, 150}, 0, 1.5, plan.terrain(), Material::earth);
  });
  scene.place(ground, SE3(), ObjectClass::ground);
  const Scenery scenery(scene, plan.terrain(), seed);
  RandomSequence random(seed, 2300);
  for (int k = 0; k < plan.bushes; ++k)
    scenery.put_bush(polar(random.uniform(8, 45), random.uniform(0, kTurn)), k, random.uniform(0, kTurn));
  add_flyers(scene, seed, plan.flyers);
}

RoadUser hill_walker(const HillPlan& plan) {
  return {ObjectClass::person,
          wavy_ring({0, 0}, plan.way_m, 0.5, 0, 2 * kMaxSceneDuration_s, false),
          0,
          1.1,
          0.8,
          0};
}

Scene flyer(const SceneOptions& options) {
  const HillPlan plan;
  SceneBuilder builder;
  build_hill(plan, builder, options.seed);
  const auto tracks =
      drive_all({hill_walker(plan)}, {}, plan.terrain(), options.duration_s + kMargin_s, options.seed);
  Scene scene;
  scene.poses = sample_poses([&](double t) { return carried(*tracks.front(), 1.9, t); }, options.duration_s);
  scene.world = builder.take();
  return scene;
}

}  // namespace mapless
