#include "simulation/scenes/scenery.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "simulation/traffic/vehicles.hpp"

namespace mapless::inline v1 {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kFloor = 3.0;  // height of a storey [m]

Vector3d on(const Terrain& terrain, double x, double y, double lift) { return {x, y, terrain(x, y) + lift}; }

void add_window(Mesh& mesh, double x, double z) {
  mesh.add_quad({x - 0.5, -0.02, z}, {x + 0.5, -0.02, z}, {x + 0.5, -0.02, z + 1.3},
                {x - 0.5, -0.02, z + 1.3}, Material::glass);
  mesh.add_box({x - 0.65, -0.2, z - 0.12}, {x + 0.65, 0, z}, Material::concrete);
  mesh.add_box({x - 0.65, -0.1, z}, {x - 0.5, 0, z + 1.4}, Material::wood);
  mesh.add_box({x + 0.5, -0.1, z}, {x + 0.65, 0, z + 1.4}, Material::wood);
  mesh.add_box({x - 0.65, -0.12, z + 1.3}, {x + 0.65, 0, z + 1.42}, Material::concrete);
}

void add_leaves(Mesh& mesh, RandomSequence& random, const Vector3d& centre, const Vector3d& radii,
                int count) {
  for (int i = 0; i < count; ++i) {
    Vector3d p;
    do {
      p = {random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
    } while (p.norm() > 1 || p.norm() < 0.45);
    const Vector3d at = centre + radii.cwiseProduct(p);
    const auto edge = [&] {
      return Vector3d(random.uniform(-0.16, 0.16), random.uniform(-0.16, 0.16), random.uniform(-0.16, 0.16));
    };
    mesh.add_triangle(at, at + edge(), at + edge(), Material::foliage);
  }
}

}  // namespace

Mesh ground_patch(const Vector2d& low, const Vector2d& high, double lift_m, double cell_m,
                  const Terrain& terrain, Material m) {
  Mesh mesh;
  const int nx = std::max(1, static_cast<int>(std::ceil((high.x() - low.x()) / cell_m)));
  const int ny = std::max(1, static_cast<int>(std::ceil((high.y() - low.y()) / cell_m)));
  const auto at = [&](int i, int j) {
    return on(terrain, low.x() + (high.x() - low.x()) * i / nx, low.y() + (high.y() - low.y()) * j / ny,
              lift_m);
  };
  for (int i = 0; i < nx; ++i) {
    for (int j = 0; j < ny; ++j) mesh.add_quad(at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1), m);
  }
  return mesh;
}

Mesh patch_edge(const Vector2d& low, const Vector2d& high, double lift_m, double cell_m,
                const Terrain& terrain, Material m) {
  Mesh mesh;
  const auto wall = [&](const Vector2d& a, const Vector2d& b) {
    const int n = std::max(1, static_cast<int>(std::ceil((b - a).norm() / cell_m)));
    for (int i = 0; i < n; ++i) {
      const Vector2d p = a + (b - a) * i / n;
      const Vector2d q = a + (b - a) * (i + 1) / n;
      mesh.add_quad(on(terrain, p.x(), p.y(), -0.05), on(terrain, q.x(), q.y(), -0.05),
                    on(terrain, q.x(), q.y(), lift_m), on(terrain, p.x(), p.y(), lift_m), m);
    }
  };
  wall(low, {high.x(), low.y()});
  wall({high.x(), low.y()}, high);
  wall(high, {low.x(), high.y()});
  wall({low.x(), high.y()}, low);
  return mesh;
}

Mesh house(RandomSequence& random, double width_m, double depth_m, int floors) {
  Mesh mesh;
  const double w = width_m / 2;
  const double top = kFloor * floors + 0.5;
  const Material wall = random.chance(0.5) ? Material::brick : Material::concrete;
  mesh.add_box({-w, 0, -1.5}, {w, depth_m, top}, wall);
  mesh.add_box({-w - 0.08, -0.08, -1.5}, {w + 0.08, depth_m, 0.5}, Material::concrete);  // plinth
  if (random.chance(0.7)) {
    const double ridge = top + random.uniform(2, 3.5);
    const double eave = 0.4;
    for (const double y : {-eave, depth_m + eave}) {
      mesh.add_quad({-w - eave, y, top - 0.1}, {w + eave, y, top - 0.1}, {w + eave, depth_m / 2, ridge},
                    {-w - eave, depth_m / 2, ridge}, Material::brick);
    }
    for (const double x : {-w, w})
      mesh.add_triangle({x, 0, top}, {x, depth_m, top}, {x, depth_m / 2, ridge}, wall);
    mesh.add_box({w / 2, depth_m / 3, top}, {w / 2 + 0.6, depth_m / 3 + 0.6, ridge + 0.8}, Material::brick);
  } else {
    mesh.add_box({-w - 0.1, -0.1, top}, {w + 0.1, depth_m + 0.1, top + 0.5}, Material::concrete);
  }
  const int windows = std::max(2, static_cast<int>(width_m / 2.4));
  const int door = random.index(windows);
  const bool balconies = random.chance(0.4);
  for (int f = 0; f < floors; ++f) {
    for (int i = 0; i < windows; ++i) {
      const double x = -w + width_m * (i + 0.5) / windows;
      const double z = kFloor * f + 1.4;
      if (f == 0 && i == door) {
        mesh.add_box({x - 0.6, -0.05, 0.4}, {x + 0.6, 0, 2.6}, Material::wood);
        mesh.add_box({x - 0.8, -0.9, -1}, {x + 0.8, 0, 0.35}, Material::concrete);
        continue;
      }
      add_window(mesh, x, z);
      if (!balconies || f == 0 || i % 2 == 0) continue;
      mesh.add_box({x - 1.1, -1.2, z - 1.0}, {x + 1.1, 0, z - 0.85}, Material::concrete);
      mesh.add_box({x - 1.1, -1.2, z - 0.85}, {x + 1.1, -1.15, z + 0.1}, Material::metal);
    }
  }
  return mesh;
}

Mesh tree(RandomSequence& random, double height_m) {
  Mesh mesh;
  const double crown = 0.35 * height_m;
  mesh.add_frustum({0, 0, -0.5}, 0.035 * height_m, {0, 0, 0.75 * height_m}, 0.012 * height_m, 8,
                   Material::wood);
  for (int i = 0; i < 9; ++i) {
    const double z = height_m * random.uniform(0.35, 0.65);
    const double angle = random.uniform(0, 2 * std::numbers::pi);
    const double reach = crown * random.uniform(0.5, 0.9);
    const Vector3d tip(reach * std::cos(angle), reach * std::sin(angle), z + 0.6 * reach);
    mesh.add_frustum({0, 0, z}, 0.06, tip, 0.02, 5, Material::wood);
    add_leaves(mesh, random, tip, Vector3d::Constant(0.22 * height_m * random.uniform(0.6, 1)), 260);
  }
  add_leaves(mesh, random, {0, 0, 0.72 * height_m}, {crown, crown, 0.28 * height_m}, 1200);
  return mesh;
}

Mesh bush(RandomSequence& random) {
  Mesh mesh;
  add_leaves(mesh, random, {0, 0, 0.6}, {0.9, 0.9, 0.7}, 500);
  for (int i = 0; i < 6; ++i) {
    mesh.add_frustum({0, 0, -0.2}, 0.03, {random.uniform(-0.6, 0.6), random.uniform(-0.6, 0.6), 1}, 0.01, 4,
                     Material::wood);
  }
  return mesh;
}

Mesh lamp_post() {
  Mesh mesh;
  mesh.add_frustum({0, 0, -0.5}, 0.11, {0, 0, 7}, 0.06, 8, Material::metal);
  mesh.add_frustum({0, 0, 6.9}, 0.05, {0, -1.8, 7.2}, 0.04, 6, Material::metal);
  mesh.add_box({-0.15, -2.4, 7.1}, {0.15, -1.7, 7.3}, Material::metal);
  return mesh;
}

Mesh traffic_light() {
  Mesh mesh;
  mesh.add_frustum({0, 0, -0.5}, 0.08, {0, 0, 3.6}, 0.07, 8, Material::metal);
  mesh.add_box({-0.18, -0.15, 2.6}, {0.18, 0.15, 3.6}, Material::dark_paint);
  return mesh;
}

Mesh street_sign() {
  Mesh mesh;
  mesh.add_frustum({0, 0, -0.5}, 0.035, {0, 0, 2.8}, 0.035, 6, Material::metal);
  mesh.add_frustum({0, -0.04, 2.5}, 0.32, {0, -0.06, 2.5}, 0.32, 12, Material::metal);
  return mesh;
}

Mesh picket_fence(double length_m) {
  Mesh mesh;
  for (double x = 0; x < length_m; x += 0.16)
    mesh.add_box({x, -0.015, 0.05}, {x + 0.09, 0.015, 1.1}, Material::wood);
  for (const double z : {0.3, 0.85}) mesh.add_box({0, 0.015, z}, {length_m, 0.05, z + 0.08}, Material::wood);
  for (const double x : {0.0, length_m / 2})
    mesh.add_box({x, 0.02, -0.6}, {x + 0.1, 0.12, 1.2}, Material::wood);
  return mesh;
}

Mesh wire_fence(double length_m) {
  Mesh mesh;
  for (double z = 0.1; z < 1.8; z += 0.2)
    mesh.add_box({0, -0.006, z}, {length_m, 0.006, z + 0.012}, Material::metal);
  for (double x = 0; x < length_m; x += 0.12)
    mesh.add_box({x, -0.006, 0.1}, {x + 0.012, 0.006, 1.8}, Material::metal);
  for (const double x : {0.0, length_m / 2})
    mesh.add_frustum({x, 0, -0.6}, 0.04, {x, 0, 1.9}, 0.04, 6, Material::metal);
  return mesh;
}

SE3 Scenery::upright(const Vector2d& p, double angle) const {
  return {rotation_z(angle), {p.x(), p.y(), terrain_(p.x(), p.y())}};
}

void Scenery::put_tree(const Vector2d& p, int variant, double angle) const {
  const int form = variant % 6;
  const auto shape = scene_.shape(fmt::format("tree {}", form), [&] {
    RandomSequence random(seed_, 1000 + static_cast<std::uint64_t>(form));
    return tree(random, 5.5 + 1.1 * form);
  });
  scene_.place(shape, upright(p, angle), ObjectClass::vegetation);
}

void Scenery::put_bush(const Vector2d& p, int variant, double angle) const {
  const int form = variant % 4;
  const auto shape = scene_.shape(fmt::format("bush {}", form), [&] {
    RandomSequence random(seed_, 1100 + static_cast<std::uint64_t>(form));
    return bush(random);
  });
  scene_.place(shape, upright(p, angle), ObjectClass::vegetation);
}

void Scenery::put_house(const Vector2d& front, double angle, int variant) const {
  const int form = variant % 12;
  const auto shape = scene_.shape(fmt::format("house {}", form), [&] {
    RandomSequence random(seed_, 1200 + static_cast<std::uint64_t>(form));
    return house(random, house_width(form), 10, 2 + form % 3);
  });
  scene_.place(shape, upright(front, angle), ObjectClass::building);
}

void Scenery::put_lamp(const Vector2d& p, double angle) const {
  scene_.place(scene_.shape("lamp", lamp_post), upright(p, angle), ObjectClass::furniture);
}

void Scenery::put_traffic_light(const Vector2d& p, double angle) const {
  scene_.place(scene_.shape("traffic light", traffic_light), upright(p, angle), ObjectClass::furniture);
}

void Scenery::put_sign(const Vector2d& p, double angle) const {
  scene_.place(scene_.shape("sign", street_sign), upright(p, angle), ObjectClass::furniture);
}

void Scenery::put_fence(const Vector2d& p, double angle, bool wire) const {
  const auto shape = wire ? scene_.shape("wire fence", [] { return wire_fence(6); })
                          : scene_.shape("picket fence", [] { return picket_fence(6); });
  scene_.place(shape, upright(p, angle), ObjectClass::furniture);
}

void Scenery::put_parked(const Vector2d& p, double angle, ObjectClass c, int variant) const {
  park_vehicle(scene_, c, variant, pose_on_ground(p, {std::cos(angle), std::sin(angle)}, terrain_));
}

}  // namespace mapless
