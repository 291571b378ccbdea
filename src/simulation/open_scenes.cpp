#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

#include "simulation/scenes.hpp"

namespace mapless {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kTurn = 2 * std::numbers::pi;

Vector2d polar(double radius, double angle) { return {radius * std::cos(angle), radius * std::sin(angle)}; }

// Round and round a wavy ring about `centre`, long enough for any duration.
std::shared_ptr<const Path> wavy_ring(const Vector2d& centre, double radius, double wave, double phase,
                                      double length, bool clockwise) {
  std::vector<Vector2d> points;
  const double step = 2 / radius;
  for (double a = 0; a * radius < length; a += step) {
    const double angle = (clockwise ? -a : a) + phase;
    const double r = radius + wave * std::sin(3 * angle + phase) + 0.5 * wave * std::sin(5 * angle);
    points.push_back(centre + polar(r, angle));
  }
  return std::make_shared<Path>(points);
}

constexpr double kRing = 955;  // radius of the highway: 6 km round

void build_highway(const Scenery& scenery, std::uint64_t seed) {
  SceneBuilder& scene = scenery.scene();
  const auto ground = scene.shape("ground", [&] {
    const Vector2d half = Vector2d::Constant(kRing + 160);
    return ground_patch(-half, half, 0, 12, scenery.terrain(), Material::asphalt);
  });
  scene.place(ground, SE3(), ObjectClass::ground);
  const auto rail = scene.shape("rail", [] {
    Mesh mesh;
    mesh.add_box({0, -0.04, 0.45}, {10, 0.04, 0.75}, Material::metal);
    for (const double x : {0.0, 3.3, 6.6})
      mesh.add_box({x, -0.06, -0.5}, {x + 0.1, 0.06, 0.7}, Material::metal);
    return mesh;
  });
  for (const double radius : {kRing - 10.5, kRing - 0.7, kRing + 0.7, kRing + 10.5}) {
    const int pieces = static_cast<int>(kTurn * radius / 10);
    for (int k = 0; k < pieces; ++k) {
      const double angle = kTurn * k / pieces;
      const Vector2d p = polar(radius, angle);
      scene.place(rail, SE3(rotation_z(angle + kTurn / 4), {p.x(), p.y(), scenery.terrain()(p.x(), p.y())}),
                  ObjectClass::furniture);
    }
  }
  RandomSequence random(seed, 2100);
  for (int k = 0; k < 700; ++k) {
    const double angle = kTurn * k / 700;
    const double out = random.chance(0.5) ? random.uniform(14, 50) : -random.uniform(14, 50);
    if (k % 9 == 0) scenery.put_lamp(polar(kRing + 11.5, angle), angle - kTurn / 4);
    if (k % 25 == 0) scenery.put_sign(polar(kRing + 12, angle), angle);
    if (k % 31 == 0 && std::abs(out) > 30) {
      scenery.put_house(polar(kRing + out, angle), angle + kTurn / 4, random.index(12));
      continue;
    }
    scenery.put_tree(polar(kRing + out, angle), random.index(6), angle * 7);
  }
}

std::vector<RoadUser> highway_users(const SceneOptions& options) {
  struct Lane {
    double radius, speed;
    bool oncoming;
  };
  // Right-hand traffic, counter-clockwise on the outer lanes.
  const std::vector<Lane> lanes = {
      {kRing + 3, 30, false}, {kRing + 6.7, 24, false}, {kRing - 3, 30, true}, {kRing - 6.7, 25, true}};
  std::vector<RoadUser> users;
  for (std::size_t l = 0; l < lanes.size(); ++l) {
    const Lane& lane = lanes[l];
    const auto path = wavy_ring({0, 0}, lane.radius, 0, 0, 34 * kMaxSceneDuration_s, lane.oncoming);
    RandomSequence random(options.seed, 3100 + l);
    double start = 100;
    while (start < kTurn * lane.radius - 100) {
      RoadUser user;
      const double kind = random.uniform(0, 1);
      const bool slow_lane = l % 2 == 1;
      user.object_class = slow_lane && kind < 0.35   ? ObjectClass::truck
                          : slow_lane && kind < 0.42 ? ObjectClass::bus
                          : kind < 0.6               ? ObjectClass::van
                          : kind < 0.66              ? ObjectClass::motorcycle
                                                     : ObjectClass::car;
      if (users.empty()) user.object_class = ObjectClass::car;  // that is us
      user.path = path;
      user.start_m = start;
      user.desired_speed = lane.speed * random.uniform(0.93, 1.06);
      users.push_back(std::move(user));
      start += random.uniform(45, 190);
    }
  }
  return users;
}

constexpr double kForest = 130;  // half its width

Terrain forest_ground() {
  return [](double x, double y) {
    return 3.5 * std::sin(x / 17 + 0.5) * std::cos(y / 21) + 1.6 * std::sin(x / 6.5 + y / 9) +
           0.25 * std::sin(x / 1.9) * std::sin(y / 2.3);
  };
}

// Walkers must not run through trunks.
bool off_the_paths(const std::vector<RoadUser>& users, const Vector2d& p) {
  return std::none_of(users.begin(), users.end(), [&](const RoadUser& user) {
    const double once_round = std::min(user.path->length_m(), 700.0);
    for (double s = 0; s < once_round; s += 1) {
      if ((user.path->at(s) - p).squaredNorm() < 1) return true;
    }
    return false;
  });
}

void build_forest(const Scenery& scenery, const std::vector<RoadUser>& users, std::uint64_t seed) {
  SceneBuilder& scene = scenery.scene();
  const auto ground = scene.shape("ground", [&] {
    const Vector2d half = Vector2d::Constant(kForest);
    return ground_patch(-half, half, 0, 0.8, scenery.terrain(), Material::earth);
  });
  scene.place(ground, SE3(), ObjectClass::ground);
  RandomSequence random(seed, 2200);
  for (int k = 0; k < 1500; ++k) {
    const Vector2d p(random.uniform(-kForest, kForest), random.uniform(-kForest, kForest));
    const int variant = random.index(24);
    const double angle = random.uniform(0, kTurn);
    if (!off_the_paths(users, p)) continue;
    if (k % 3 == 2) {
      scenery.put_bush(p, variant, angle);
    } else {
      scenery.put_tree(p, variant, angle);
    }
  }
}

std::vector<RoadUser> forest_walkers(const SceneOptions& options) {
  std::vector<RoadUser> users;
  for (std::size_t k = 0; k < 26; ++k) {
    RandomSequence random(options.seed, 3200 + k);
    RoadUser user;
    user.object_class = k % 6 == 5 ? ObjectClass::dog : ObjectClass::person;
    const Vector2d centre(random.uniform(-25, 25), random.uniform(-25, 25));
    user.path = wavy_ring(k == 0 ? Vector2d(0, 0) : centre, k == 0 ? 45 : random.uniform(15, 60),
                          random.uniform(1, 4), random.uniform(0, kTurn), 2 * kMaxSceneDuration_s,
                          random.chance(0.5));
    user.desired_speed = random.uniform(0.9, 1.8);
    user.wheelbase_m = 0.8;
    user.start_m = random.uniform(0, 100);
    user.stop_every_s = k == 0 ? 0 : 50;
    users.push_back(std::move(user));
  }
  return users;
}

// Carried on the back: every step is felt.
SE3 carried(const Track& track, double height, double t) {
  const double steps = kTurn * track.distance_m(t) / 0.7;
  const SE3 sway(
      so3_exp({0.04 * std::sin(steps / 2), 0.03 * std::sin(steps), 0.06 * std::sin(steps / 2 + 0.7)}),
      {0, 0.03 * std::sin(steps / 2), height + 0.03 * std::sin(steps)});
  return track.pose(t) * sway;
}

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

Scene highway(const SceneOptions& options) {
  const Terrain terrain = [](double x, double y) { return 4 * std::sin(x / 310) * std::cos(y / 270); };
  SceneBuilder builder;
  build_highway(Scenery(builder, terrain, options.seed), options.seed);
  const auto users = highway_users(options);
  const auto tracks = drive_all(users, {}, terrain, options.duration_s + kMargin_s, options.seed);
  add_users(builder, users, tracks, 1);
  Scene scene;
  scene.poses = ride(*tracks.front(), SE3(Eigen::Matrix3d::Identity(), {0, 0, 1.95}), options.duration_s);
  scene.world = builder.take();
  return scene;
}

Scene forest(const SceneOptions& options) {
  SceneBuilder builder;
  const auto users = forest_walkers(options);
  build_forest(Scenery(builder, forest_ground(), options.seed), users, options.seed);
  const auto tracks = drive_all(users, {}, forest_ground(), options.duration_s + kMargin_s, options.seed);
  add_users(builder, users, tracks, 1);
  Scene scene;
  scene.poses = sample_poses([&](double t) { return carried(*tracks.front(), 1.9, t); }, options.duration_s);
  scene.world = builder.take();
  return scene;
}

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
