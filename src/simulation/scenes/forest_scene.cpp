#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "simulation/scenes/clearings.hpp"
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

constexpr double kForest = 130;  // half its width

Terrain forest_ground() {
  return [](double x, double y) {
    return 1.8 * std::sin(x / 24 + 0.5) * std::cos(y / 28) + 0.7 * std::sin(x / 8 + y / 10) +
           0.2 * std::sin(x / 1.9) * std::sin(y / 2.3);
  };
}

Clearings about_paths(const std::vector<RoadUser>& users) {
  Clearings clearings(kForest);
  for (const RoadUser& user : users) {
    const double once_round = std::min(user.path->length_m(), 700.0);
    for (double s = 0; s < once_round; s += 1) clearings.take(user.path->at(s), 1.2);
  }
  return clearings;
}

void build_forest(const Scenery& scenery, const std::vector<RoadUser>& users, std::uint64_t seed) {
  SceneBuilder& scene = scenery.scene();
  const auto ground = scene.shape("ground", [&] {
    const Vector2d half = Vector2d::Constant(kForest);
    return ground_patch(-half, half, 0, 0.8, scenery.terrain(), Material::earth);
  });
  scene.place(ground, SE3(), ObjectClass::ground);
  Clearings clearings = about_paths(users);
  RandomSequence random(seed, 2200);
  for (int k = 0; k < 9000; ++k) {
    const Vector2d p(random.uniform(-kForest, kForest), random.uniform(-kForest, kForest));
    const int variant = random.index(24);
    const double angle = random.uniform(0, kTurn);
    if (!clearings.is_free(p)) continue;
    clearings.take(p, 1);
    if (k % 4 == 3) {
      scenery.put_bush(p, variant, angle);
    } else {
      scenery.put_tree(p, variant, angle);
    }
  }
}

std::vector<RoadUser> forest_walkers(const SceneOptions& options) {
  constexpr std::size_t kWays = 8;
  std::vector<RoadUser> users;
  for (std::size_t k = 0; k < 26; ++k) {
    const std::size_t way = k % kWays;
    RandomSequence random(options.seed, 3200 + k);
    RandomSequence laying(options.seed, 3250 + way);
    RoadUser user;
    user.object_class = k % 6 == 5 ? ObjectClass::dog : ObjectClass::person;
    const Vector2d centre(laying.uniform(-25, 25), laying.uniform(-25, 25));
    const double radius = laying.uniform(15, 60);
    const double wave = laying.uniform(1, 4);
    const double phase = laying.uniform(0, kTurn);
    user.path = wavy_ring(way == 0 ? Vector2d(0, 0) : centre, way == 0 ? 45 : radius, wave, phase,
                          2 * kMaxSceneDuration_s, random.chance(0.5));
    user.desired_speed = random.uniform(0.9, 1.8);
    user.wheelbase_m = 0.8;
    user.start_m = random.uniform(0, 100);
    user.stop_every_s = k == 0 ? 0 : 50;
    users.push_back(std::move(user));
  }
  return users;
}

}  // namespace

Scene forest(const SceneOptions& options) {
  SceneBuilder builder;
  const auto users = forest_walkers(options);
  build_forest(Scenery(builder, forest_ground(), options.seed), users, options.seed);
  const auto tracks = drive_all(users, {}, forest_ground(), options.duration_s + kMargin_s, options.seed);
  add_movers(builder, users, tracks, 1);
  Scene scene;
  scene.poses = sample_poses([&](double t) { return carried(*tracks.front(), 1.9, t); }, options.duration_s);
  scene.world = builder.take();
  return scene;
}

}  // namespace mapless
