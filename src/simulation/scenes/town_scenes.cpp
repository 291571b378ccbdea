#include <cmath>

#include "simulation/scenes/named_scenes.hpp"
#include "simulation/scenes/sensor_poses.hpp"
#include "simulation/scenes/town.hpp"
#include "simulation/traffic/bodies.hpp"
#include "simulation/traffic/traffic.hpp"

namespace mapless::inline v1 {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kRoof = 1.95;  // height of the sensor over the road [m]

TownPlan crossing_plan() {
  TownPlan plan;
  plan.nx = plan.ny = 3;
  plan.dx_m = plan.dy_m = 100;
  plan.cars = 22;
  plan.vans = 4;
  plan.buses = 6;
  plan.cyclists = 6;
  return plan;
}

// `poses` from the track of the vehicle with the sensor, which is absent where `with_ego` is false.
template <typename Poses>
Scene town_scene(const TownPlan& plan, const SceneOptions& options, bool with_ego, const Poses& poses) {
  SceneBuilder builder;
  build_town(plan, Scenery(builder, plan.terrain(), options.seed), options.seed);
  const auto users = town_people(plan, options, with_ego);
  const auto tracks =
      drive_all(users, plan.junctions(), plan.terrain(), options.duration_s + kMargin_s, options.seed);
  add_movers(builder, users, tracks, with_ego ? 1 : 0);
  Scene scene;
  scene.poses = poses(*tracks.front());
  scene.world = builder.take();
  return scene;
}

Scene drive_through(const TownPlan& plan, const SceneOptions& options, const SE3& T_bv) {
  return town_scene(plan, options, true,
                    [&](const Track& track) { return ride(track, T_bv, options.duration_s); });
}

SE3 on_roof() { return {Eigen::Matrix3d::Identity(), {0, 0, kRoof}}; }

}  // namespace

TownPlan town1_plan() { return {}; }  // 9 x 180 + 8 x 160 = 2900 m of street

TownPlan town2_plan() {  // 9 x 120 + 8 x 102.5 = 1900 m, narrower, with more fences
  TownPlan plan;
  plan.dx_m = 120;
  plan.dy_m = 102.5;
  plan.half_road_m = 5.0;
  plan.lane_m = 1.7;
  plan.pavement_m = 2.2;
  plan.front_garden_m = 2.5;
  plan.fences = 0.75;
  plan.parked = 0.7;
  plan.speed = 9;
  plan.hills_m = 2.2;
  plan.cars = 22;
  plan.buses = 3;
  plan.people = 90;
  return plan;
}

Scene town1(const SceneOptions& options) { return drive_through(town1_plan(), options, on_roof()); }

Scene town2(const SceneOptions& options) { return drive_through(town2_plan(), options, on_roof()); }

Scene tilted(const SceneOptions& options) {
  RandomSequence random(options.seed, 77);
  const Vector3d axis(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-0.3, 0.3));
  const SE3 T_bv(so3_exp(axis.normalized() * random.uniform(0.35, 1.6)), {0, 0, kRoof + 0.4});
  return drive_through(town1_plan(), options, T_bv);
}

Scene crossing(const SceneOptions& options) {
  const TownPlan plan = crossing_plan();
  // On a tripod at the corner of the middle junction.
  const double corner = plan.half_road_m + 2.75;
  const Vector2d at = plan.junction(1, 1) + Vector2d(corner, corner);
  const SE3 T_0v(rotation_z(0.6), {at.x(), at.y(), plan.terrain()(at.x(), at.y()) + 2.2});
  return town_scene(plan, options, false, [&](const Track&) {
    return sample_poses([&](double) { return T_0v; }, options.duration_s);
  });
}

}  // namespace mapless
