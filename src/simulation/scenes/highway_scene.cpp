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

constexpr double kRing = 955;  // radius of the highway: 6 km round

// The carriageways, just above the ground.
Mesh road_surface(const Terrain& terrain) {
  constexpr double kHalf = 10.6;
  constexpr int kPieces = 1000, kAcross = 4;
  Mesh mesh;
  const auto at = [&](int piece, int across) {
    const Vector2d p = polar(kRing - kHalf + 2 * kHalf * across / kAcross, kTurn * piece / kPieces);
    return Vector3d(p.x(), p.y(), terrain(p.x(), p.y()) + 0.02);
  };
  for (int k = 0; k < kPieces; ++k) {
    for (int c = 0; c < kAcross; ++c)
      mesh.add_quad(at(k, c), at(k + 1, c), at(k + 1, c + 1), at(k, c + 1), Material::asphalt);
  }
  return mesh;
}

// A bridge over the road, x across it from its middle.
Mesh overpass() {
  Mesh mesh;
  mesh.add_box({-26, -5, 5.4}, {26, 5, 6.3}, Material::concrete);
  for (const double y : {-5.0, 4.8}) mesh.add_box({-26, y, 6.3}, {26, y + 0.2, 7.3}, Material::concrete);
  for (const double x : {-12.5, 0.0, 12.5}) {
    for (const double y : {-3.5, 0.0, 3.5})
      mesh.add_frustum({x, y, -0.5}, 0.45, {x, y, 5.4}, 0.45, 10, Material::concrete);
  }
  for (const double x : {-26.0, 15.0})  // embankments
    mesh.add_extrusion(x < 0 ? std::vector<Vector2d>{{x - 10, -0.5}, {-15, -0.5}, {-20, 5.4}, {x - 10, 5.4}}
                             : std::vector<Vector2d>{{x, -0.5}, {36, -0.5}, {36, 5.4}, {20, 5.4}},
                       5, Material::earth);
  return mesh;
}

// Signs over the outer carriageway, x across the road from its middle.
Mesh gantry() {
  Mesh mesh;
  for (const double x : {1.5, 11.8})
    mesh.add_frustum({x, 0, -0.5}, 0.2, {x, 0, 6.6}, 0.16, 8, Material::metal);
  mesh.add_box({1.5, -0.15, 6.2}, {11.8, 0.15, 6.6}, Material::metal);
  for (const double x : {2.2, 6.2}) mesh.add_box({x, -0.3, 5.2}, {x + 3.4, -0.2, 7.4}, Material::metal);
  return mesh;
}

// Ten metres of a wall against the noise, along x.
Mesh noise_wall() {
  Mesh mesh;
  for (const double x : {0.0, 5.0}) {
    mesh.add_box({x, -0.15, -0.6}, {x + 0.3, 0.15, 3.7}, Material::metal);
    mesh.add_box({x + 0.3, -0.06, -0.6}, {x + 5.05, 0.06, 3.6}, Material::wood);
  }
  return mesh;
}

void put_walls_and_bridges(const Scenery& scenery) {
  SceneBuilder& scene = scenery.scene();
  const auto put = [&](std::size_t shape, double radius, double angle, double turned) {
    const Vector2d p = polar(radius, angle);
    scene.place(shape, SE3(rotation_z(angle + turned), {p.x(), p.y(), scenery.terrain()(p.x(), p.y())}),
                ObjectClass::building);
  };
  for (int k = 0; k < 7; ++k) put(scene.shape("overpass", overpass), kRing, kTurn * (k + 0.4) / 7, 0);
  for (int k = 0; k < 9; ++k) put(scene.shape("gantry", gantry), kRing, kTurn * (k + 0.2) / 9, 0);
  const int pieces = static_cast<int>(kTurn * (kRing + 13.5) / 10);
  for (int k = 0; k < pieces; ++k) {
    if (k % 90 < 35) put(scene.shape("noise wall", noise_wall), kRing + 13.5, kTurn * k / pieces, kTurn / 4);
  }
}

// Lamps, signs, farms and a belt of trees and bushes on either side.
void build_verges(const Scenery& scenery, std::uint64_t seed) {
  put_walls_and_bridges(scenery);
  RandomSequence random(seed, 2100);
  const auto beside_bridge = [](double angle) {
    return std::abs(std::remainder(angle - kTurn * 0.4 / 7, kTurn / 7)) * kRing < 8;
  };
  for (int k = 0; k < 2100; ++k) {
    const double angle = kTurn * k / 2100;
    const double out = random.chance(0.5) ? random.uniform(16, 50) : -random.uniform(14, 50);
    const double form = random.uniform(0, 1);
    if (k % 27 == 0) scenery.put_lamp(polar(kRing + 11.5, angle), angle - kTurn / 4);
    if (k % 75 == 0) scenery.put_sign(polar(kRing + 12, angle), angle);
    if (beside_bridge(angle)) continue;
    if (k % 93 == 0 && std::abs(out) > 30) {
      scenery.put_house(polar(kRing + out, angle), angle + kTurn / 4, random.index(12));
    } else if (form < 0.3) {
      scenery.put_bush(polar(kRing + 0.6 * out + (out > 0 ? 7 : -7), angle), random.index(4), angle * 7);
    } else {
      scenery.put_tree(polar(kRing + out, angle), random.index(6), angle * 7);
    }
  }
}

void build_highway(const Scenery& scenery, std::uint64_t seed) {
  SceneBuilder& scene = scenery.scene();
  const auto ground = scene.shape("ground", [&] {
    const Vector2d half = Vector2d::Constant(kRing + 160);
    return ground_patch(-half, half, 0, 12, scenery.terrain(), Material::earth);
  });
  scene.place(ground, SE3(), ObjectClass::ground);
  scene.place(scene.shape("road", [&] { return road_surface(scenery.terrain()); }), SE3(),
              ObjectClass::ground);
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
  build_verges(scenery, seed);
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

}  // namespace

Scene highway(const SceneOptions& options) {
  const Terrain terrain = [](double x, double y) { return 4 * std::sin(x / 310) * std::cos(y / 270); };
  SceneBuilder builder;
  build_highway(Scenery(builder, terrain, options.seed), options.seed);
  const auto users = highway_users(options);
  const auto tracks = drive_all(users, {}, terrain, options.duration_s + kMargin_s, options.seed);
  add_movers(builder, users, tracks, 1);
  Scene scene;
  scene.poses = ride(*tracks.front(), SE3(Eigen::Matrix3d::Identity(), {0, 0, 1.95}), options.duration_s);
  scene.world = builder.take();
  return scene;
}

}  // namespace mapless
