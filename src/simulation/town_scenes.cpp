#include <cmath>

#include "simulation/town.hpp"

namespace mapless {
namespace {

using Eigen::Vector3d;

constexpr double kRoof = 1.95;  // height of the sensor over the road [m]

Scene drive_through(const TownPlan& plan, const SceneOptions& options, const SE3& T_bv) {
  SceneBuilder builder;
  const Scenery scenery(builder, plan.terrain(), options.seed);
  build_town(plan, scenery, options.seed);
  const auto users = town_people(plan, options, true);
  const auto tracks =
      drive_all(users, plan.junctions(), plan.terrain(), options.duration_s + kMargin_s, options.seed);
  add_users(builder, users, tracks, 1);
  Scene scene;
  scene.poses = ride(*tracks.front(), T_bv, options.duration_s);
  scene.world = builder.take();
  return scene;
}

SE3 on_roof() { return {Eigen::Matrix3d::Identity(), {0, 0, kRoof}}; }

}  // namespace

Scene town1(const SceneOptions& options) {
  const TownPlan plan;  // 9 x 180 + 8 x 160 = 2900 m of street
  return drive_through(plan, options, on_roof());
}

Scene town2(const SceneOptions& options) {
  TownPlan plan;  // 9 x 120 + 8 x 102.5 = 1900 m, narrower, with more fences
  plan.dx_m = 120;
  plan.dy_m = 102.5;
  plan.half_road_m = 4.9;
  plan.pavement_m = 2.2;
  plan.front_garden_m = 2.5;
  plan.fences = 0.75;
  plan.parked = 0.7;
  plan.speed = 9;
  plan.hills_m = 2.2;
  plan.cars = 22;
  plan.buses = 3;
  plan.people = 90;
  return drive_through(plan, options, on_roof());
}

Scene tilted(const SceneOptions& options) {
  RandomSequence random(options.seed, 77);
  const Vector3d axis(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-0.3, 0.3));
  const SE3 T_bv(so3_exp(axis.normalized() * random.uniform(0.35, 1.6)), {0, 0, kRoof + 0.4});
  return drive_through(TownPlan(), options, T_bv);
}

Scene crossing(const SceneOptions& options) {
  TownPlan plan;
  plan.nx = plan.ny = 3;
  plan.dx_m = plan.dy_m = 100;
  plan.cars = 30;
  plan.vans = 6;
  plan.trucks = 3;
  plan.buses = 7;
  plan.cyclists = 9;
  plan.people = 70;
  SceneBuilder builder;
  const Scenery scenery(builder, plan.terrain(), options.seed);
  build_town(plan, scenery, options.seed);
  const auto users = town_people(plan, options, false);
  const auto tracks =
      drive_all(users, plan.junctions(), plan.terrain(), options.duration_s + kMargin_s, options.seed);
  add_users(builder, users, tracks, 0);
  Scene scene;
  // On a tripod at the corner of the middle junction.
  const double corner = plan.half_road_m + 2.4;
  const Eigen::Vector2d at = plan.junction(1, 1) + Eigen::Vector2d(corner, corner);
  const SE3 T_0v(rotation_z(0.6), {at.x(), at.y(), plan.terrain()(at.x(), at.y()) + 2.2});
  scene.poses = sample_poses([&](double) { return T_0v; }, options.duration_s);
  scene.world = builder.take();
  return scene;
}

}  // namespace mapless
