#include "simulation/traffic/vehicles.hpp"

#include <array>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>
#include <fmt/format.h>

namespace mapless::inline v1 {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

struct VehicleSize {
  double length, width, height, wheel_radius, front_axle, rear_axle;
};

VehicleSize size_of(ObjectClass c) {
  switch (c) {
    case ObjectClass::van:
      return {5.4, 2.0, 2.3, 0.34, 1.6, -1.7};
    case ObjectClass::truck:
      return {9.0, 2.5, 3.6, 0.5, 3.2, -2.6};
    case ObjectClass::bus:
      return {11.8, 2.55, 3.1, 0.5, 3.6, -3.4};
    default:
      return {4.4, 1.8, 1.5, 0.32, 1.35, -1.3};
  }
}

Material paint_of(int variant) { return variant % 4 == 3 ? Material::dark_paint : Material::paint; }

// Panes on both sides between x0 and x1, z0 and z1, 1 cm outside the body so that rays hit them first.
void add_side_windows(Mesh& mesh, double x0, double x1, double z0, double z1, double half_width) {
  for (const double y : {-half_width - 0.01, half_width + 0.01}) {
    mesh.add_quad({x0, y, z0}, {x1, y, z0}, {x1, y, z1}, {x0, y, z1}, Material::glass);
  }
}

Mesh car_body(int variant) {
  Mesh mesh;
  const double w = 0.9;
  const Material paint = paint_of(variant);
  const double roof_rear = variant % 3 == 1 ? -2.0 : -1.1;  // an estate has a longer roof
  mesh.add_extrusion({{-2.2, 0.35}, {2.15, 0.35}, {2.2, 0.62}, {1.2, 0.9}, {-2.15, 0.95}}, w, paint);
  mesh.add_extrusion({{1.15, 0.9}, {0.3, 1.46}, {roof_rear, 1.48}, {-2.1, 0.94}}, 0.78, paint);
  mesh.add_quad({1.14, -0.7, 0.95}, {1.14, 0.7, 0.95}, {0.38, 0.65, 1.44}, {0.38, -0.65, 1.44},
                Material::glass);
  add_side_windows(mesh, -1.2, 0.5, 1.0, 1.35, 0.78);
  for (const double y : {-1.0, 0.9}) mesh.add_box({0.75, y, 0.95}, {0.95, y + 0.1, 1.1}, paint);  // mirrors
  mesh.add_box({2.15, -0.85, 0.3}, {2.28, 0.85, 0.55}, Material::dark_paint);
  mesh.add_box({-2.28, -0.85, 0.3}, {-2.15, 0.85, 0.6}, Material::dark_paint);
  return mesh;
}

Mesh van_body(int variant) {
  Mesh mesh;
  mesh.add_extrusion({{-2.7, 0.35}, {2.65, 0.35}, {2.7, 0.9}, {2.2, 1.15}, {1.5, 2.2}, {-2.65, 2.3}}, 1.0,
                     paint_of(variant));
  mesh.add_quad({2.18, -0.9, 1.2}, {2.18, 0.9, 1.2}, {1.56, 0.85, 2.15}, {1.56, -0.85, 2.15},
                Material::glass);
  add_side_windows(mesh, 0.5, 1.5, 1.2, 1.8, 1.0);
  for (const double y : {-1.2, 1.0}) mesh.add_box({1.7, y, 1.2}, {1.9, y + 0.2, 1.6}, Material::dark_paint);
  return mesh;
}

Mesh truck_body(int variant) {
  Mesh mesh;
  mesh.add_extrusion({{2.4, 0.6}, {4.5, 0.6}, {4.5, 1.6}, {4.3, 2.8}, {2.4, 2.9}}, 1.2, paint_of(variant));
  mesh.add_quad({4.49, -1.1, 1.7}, {4.49, 1.1, 1.7}, {4.32, 1.1, 2.6}, {4.32, -1.1, 2.6}, Material::glass);
  mesh.add_box({-4.5, -1.25, 1.05}, {2.2, 1.25, 3.6}, Material::metal);
  mesh.add_box({-4.4, -0.5, 0.7}, {2.4, 0.5, 1.05}, Material::dark_paint);
  return mesh;
}

Mesh bus_body(int variant) {
  Mesh mesh;
  mesh.add_extrusion({{-5.9, 0.35}, {5.85, 0.35}, {5.9, 1.2}, {5.75, 3.05}, {-5.9, 3.1}}, 1.27,
                     variant % 2 == 0 ? Material::paint : Material::metal);
  for (double x = -5.2; x < 4.5; x += 1.6) add_side_windows(mesh, x, x + 1.4, 1.3, 2.4, 1.27);
  mesh.add_quad({5.91, -1.1, 1.2}, {5.91, 1.1, 1.2}, {5.8, 1.1, 2.7}, {5.8, -1.1, 2.7}, Material::glass);
  mesh.add_box({-3, -0.9, 3.1}, {0, 0.9, 3.35}, Material::metal);
  for (const double y : {-1.5, 1.27}) mesh.add_box({5.7, y, 1.9}, {5.9, y + 0.23, 2.4}, Material::dark_paint);
  return mesh;
}

Mesh wheel(double radius, double width) {
  Mesh mesh;
  mesh.add_frustum({0, -width / 2, 0}, radius, {0, width / 2, 0}, radius, 14, Material::dark_paint);
  mesh.add_frustum({0, width / 2, 0}, 0.6 * radius, {0, width / 2 + 0.02, 0}, 0.55 * radius, 8,
                   Material::metal);
  mesh.add_frustum({0, -width / 2, 0}, 0.6 * radius, {0, -width / 2 - 0.02, 0}, 0.55 * radius, 8,
                   Material::metal);
  return mesh;
}

std::array<Vector3d, 4> wheel_places(const VehicleSize& size) {
  const double y = size.width / 2 - 0.12;
  return {{{size.front_axle, y, size.wheel_radius},
           {size.front_axle, -y, size.wheel_radius},
           {size.rear_axle, y, size.wheel_radius},
           {size.rear_axle, -y, size.wheel_radius}}};
}

std::size_t body_shape(SceneBuilder& scene, ObjectClass c, int variant) {
  return scene.shape(fmt::format("{} {}", to_string(c), variant % 12),
                     [&] { return vehicle_body(c, variant % 12); });
}

std::size_t wheel_shape(SceneBuilder& scene, double radius) {
  return scene.shape(fmt::format("wheel {}", radius), [&] { return wheel(radius, 0.22); });
}

}  // namespace

double body_length(ObjectClass c) {
  if (c == ObjectClass::person || c == ObjectClass::dog) return 0.6;
  if (c == ObjectClass::cyclist || c == ObjectClass::motorcycle) return 1.9;
  return size_of(c).length;
}

double body_width(ObjectClass c) {
  if (c == ObjectClass::person || c == ObjectClass::dog) return 0.5;
  if (c == ObjectClass::cyclist || c == ObjectClass::motorcycle) return 0.7;
  return size_of(c).width;
}

Mesh vehicle_body(ObjectClass c, int variant) {
  switch (c) {
    case ObjectClass::van:
      return van_body(variant);
    case ObjectClass::truck:
      return truck_body(variant);
    case ObjectClass::bus:
      return bus_body(variant);
    default:
      return car_body(variant);
  }
}

void add_vehicle(SceneBuilder& scene, ObjectClass c, int variant, const std::shared_ptr<const Track>& track) {
  const VehicleSize size = size_of(c);
  Mover mover;
  mover.object_class = c;
  mover.radius_m = size.length / 2 + 1.5;
  mover.T_0b = [track](Time t) { return track->pose(t.seconds()); };
  mover.parts.push_back({body_shape(scene, c, variant), nullptr});
  for (const Vector3d& place : wheel_places(size)) {
    mover.parts.push_back({wheel_shape(scene, size.wheel_radius), [track, place](Time t) {
                             const double turned = track->distance_m(t.seconds()) / place.z();
                             return SE3(so3_exp({0, std::remainder(turned, 2 * std::numbers::pi), 0}), place);
                           }});
  }
  scene.add(std::move(mover));
}

void park_vehicle(SceneBuilder& scene, ObjectClass c, int variant, const SE3& T_0b) {
  const std::string name = fmt::format("parked {} {}", to_string(c), variant % 12);
  const std::size_t shape = scene.shape(name, [&] {
    Mesh mesh = vehicle_body(c, variant % 12);
    const VehicleSize size = size_of(c);
    for (const Vector3d& place : wheel_places(size)) {
      mesh.append(wheel(size.wheel_radius, 0.22), SE3(Matrix3d::Identity(), place));
    }
    return mesh;
  });
  scene.place(shape, T_0b, c, true);
}

}  // namespace mapless
