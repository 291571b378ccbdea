#include "simulation/traffic/living.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>
#include <fmt/format.h>

namespace mapless::inline v1 {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

// Dimensions of a person of 1.75 m [m].
constexpr double kLink = 0.46;   // thigh, shin
constexpr double kHip = 0.86;    // height of the hip
constexpr double kStride = 1.4;  // two steps

Matrix3d about_y(double angle) { return so3_exp({0, angle, 0}); }

SE3 shifted(const Vector3d& at) { return {Matrix3d::Identity(), at}; }

// A limb from its joint at the origin along -z.
Mesh limb(double length, double top_radius, double end_radius, Material m) {
  Mesh mesh;
  mesh.add_frustum({0, 0, 0.02}, top_radius, {0, 0, -length}, end_radius, 7, m);
  return mesh;
}

Mesh torso(int variant) {
  Mesh mesh;
  const Material clothes = variant % 5 == 4 ? Material::dark_paint : Material::cloth;
  mesh.add_frustum({0, 0, 0.8}, 0.17, {0, 0, 1.15}, 0.15, 9, clothes);
  mesh.add_frustum({0, 0, 1.15}, 0.15, {0, 0, 1.45}, 0.21, 9, clothes);
  mesh.add_frustum({0, 0, 1.43}, 0.07, {0, 0, 1.55}, 0.06, 6, Material::cloth);
  mesh.add_ellipsoid({0.02, 0, 1.65}, {0.11, 0.09, 0.13}, 6, Material::cloth);
  if (variant % 3 == 1) mesh.add_box({-0.32, -0.16, 1.0}, {-0.15, 0.16, 1.42}, Material::cloth);  // rucksack
  return mesh;
}

Mesh foot() {
  Mesh mesh;
  mesh.add_box({-0.06, -0.045, -0.06}, {0.2, 0.045, 0.03}, Material::cloth);
  return mesh;
}

// Adds thigh, shin and foot from `hip` (x, y, z in the body) to the foot position `foot_at` (x, z).
void add_leg(SceneBuilder& scene, Mover& mover, const Vector3d& hip,
             const std::function<Vector2d(Time)>& foot_at) {
  const auto pose = [hip, foot_at](Time t) { return bend_leg({hip.x(), hip.z()}, foot_at(t), kLink); };
  const auto thigh = scene.shape("thigh", [] { return limb(kLink, 0.09, 0.065, Material::cloth); });
  const auto shin = scene.shape("shin", [] { return limb(kLink, 0.06, 0.045, Material::cloth); });
  mover.parts.push_back({thigh, [=](Time t) { return SE3(about_y(pose(t).upper_rad), hip); }});
  mover.parts.push_back({shin, [=](Time t) {
                           const LegPose leg = pose(t);
                           return SE3(about_y(leg.lower_rad), {leg.knee.x(), hip.y(), leg.knee.y()});
                         }});
  mover.parts.push_back({scene.shape("foot", foot), [=](Time t) {
                           const Vector2d at = foot_at(t);
                           return shifted({at.x(), hip.y(), at.y()});
                         }});
}

// A rigid limb that swings with the stride about its joint.
void add_swinging(Mover& mover, const std::shared_ptr<const Track>& track, std::size_t shape,
                  const Vector3d& joint, double amplitude_rad, double stride_m, double phase) {
  mover.parts.push_back({shape, [=](Time t) {
                           const double turn =
                               2 * std::numbers::pi * track->distance_m(t.seconds()) / stride_m;
                           return SE3(about_y(amplitude_rad * std::sin(turn + phase)), joint);
                         }});
}

Mesh bicycle() {
  Mesh mesh;
  for (const double x : {-0.52, 0.52}) {
    for (int i = 0; i < 16; ++i) {  // the tyre, as a ring of bars
      const double a = 2 * std::numbers::pi * i / 16;
      const double b = 2 * std::numbers::pi * (i + 1) / 16;
      mesh.add_frustum({x + 0.33 * std::cos(a), 0, 0.34 + 0.33 * std::sin(a)}, 0.02,
                       {x + 0.33 * std::cos(b), 0, 0.34 + 0.33 * std::sin(b)}, 0.02, 4, Material::dark_paint);
    }
  }
  const auto tube = [&](const Vector3d& a, const Vector3d& b) {
    mesh.add_frustum(a, 0.02, b, 0.02, 5, Material::metal);
  };
  tube({-0.52, 0, 0.34}, {-0.18, 0, 0.85});
  tube({-0.18, 0, 0.85}, {0.35, 0, 0.85});
  tube({-0.05, 0, 0.3}, {0.38, 0, 0.8});
  tube({0.52, 0, 0.34}, {0.35, 0, 1.05});
  tube({0.35, -0.28, 1.05}, {0.35, 0.28, 1.05});
  return mesh;
}

Mesh rider() {
  Mesh mesh;
  mesh.add_frustum({-0.18, 0, 0.9}, 0.16, {0.12, 0, 1.42}, 0.19, 9, Material::cloth);
  mesh.add_ellipsoid({0.2, 0, 1.62}, {0.12, 0.1, 0.13}, 6, Material::cloth);
  for (const double y : {-0.22, 0.22})
    mesh.add_frustum({0.1, y, 1.38}, 0.055, {0.36, y, 1.06}, 0.04, 6, Material::cloth);
  return mesh;
}

Mesh motorcycle() {
  Mesh mesh;
  for (const double x : {-0.68, 0.7})
    mesh.add_frustum({x, -0.07, 0.31}, 0.31, {x, 0.07, 0.31}, 0.31, 14, Material::dark_paint);
  mesh.add_extrusion({{-0.8, 0.75}, {-0.2, 0.3}, {0.4, 0.35}, {0.6, 0.95}, {0.1, 1.0}}, 0.17,
                     Material::paint);
  mesh.add_frustum({0.7, 0, 0.31}, 0.05, {0.45, 0, 1.05}, 0.05, 6, Material::metal);
  mesh.add_frustum({0.42, -0.35, 1.05}, 0.03, {0.42, 0.35, 1.05}, 0.03, 6, Material::metal);
  return mesh;
}

}  // namespace

LegPose bend_leg(const Vector2d& hip, const Vector2d& foot, double link_m) {
  const Vector2d down = foot - hip;
  const double reach = std::clamp(down.norm(), 0.1, 2 * link_m * 0.9999);
  // Angle of -z towards down, about y (x ahead): a turn by phi about y takes (0, -1) to (-sin phi, -cos phi).
  const double straight = std::atan2(-down.x(), -down.y());
  const double bend = std::acos(reach / (2 * link_m));  // the knee bends forward
  const double upper = straight - bend;
  const Vector2d knee = hip + link_m * Vector2d(-std::sin(upper), -std::cos(upper));
  return {upper, straight + bend, knee};
}

Vector2d foot_of_walker(double distance_m, double stride_m, bool left) {
  const double phase = distance_m / stride_m + (left ? 0.5 : 0);
  const double f = phase - std::floor(phase);
  if (f < 0.5) return {stride_m * (0.25 - f), 0.06};
  const double u = 2 * (f - 0.5);
  return {-0.25 * stride_m * std::cos(std::numbers::pi * u), 0.06 + 0.1 * std::sin(std::numbers::pi * u)};
}

void add_person(SceneBuilder& scene, int variant, const std::shared_ptr<const Track>& track) {
  Mover mover;
  mover.object_class = ObjectClass::person;
  mover.radius_m = 2.2;
  mover.T_0b = [track](Time t) { return track->pose(t.seconds()); };
  mover.parts.push_back(
      {scene.shape(fmt::format("torso {}", variant % 15), [&] { return torso(variant % 15); }), nullptr});
  const auto arm = scene.shape("arm", [] { return limb(0.62, 0.05, 0.04, Material::cloth); });
  for (const bool left : {false, true}) {
    const double y = left ? 0.1 : -0.1;
    add_leg(scene, mover, {0, y, kHip},
            [track, left](Time t) { return foot_of_walker(track->distance_m(t.seconds()), kStride, left); });
    add_swinging(mover, track, arm, {0, 2.4 * y, 1.4}, 0.35, kStride, left ? 0 : std::numbers::pi);
  }
  scene.add(std::move(mover));
}

void add_cyclist(SceneBuilder& scene, ObjectClass c, const std::shared_ptr<const Track>& track) {
  Mover mover;
  mover.object_class = c;
  mover.radius_m = 2.2;
  mover.T_0b = [track](Time t) { return track->pose(t.seconds()); };
  const bool motor = c == ObjectClass::motorcycle;
  mover.parts.push_back(
      {motor ? scene.shape("motorcycle", motorcycle) : scene.shape("bicycle", bicycle), nullptr});
  mover.parts.push_back({scene.shape("rider", rider), nullptr});
  for (const bool left : {false, true}) {
    add_leg(scene, mover, {-0.15, left ? 0.12 : -0.12, 0.92}, [track, left, motor](Time t) {
      if (motor) return Vector2d(0.05, 0.35);
      const double turn = track->distance_m(t.seconds()) / 0.9 + (left ? std::numbers::pi : 0);
      return Vector2d(-0.05 + 0.17 * std::cos(turn), 0.32 - 0.17 * std::sin(turn));
    });
  }
  scene.add(std::move(mover));
}

void add_dog(SceneBuilder& scene, const std::shared_ptr<const Track>& track) {
  Mover mover;
  mover.object_class = ObjectClass::dog;
  mover.radius_m = 1.2;
  mover.T_0b = [track](Time t) { return track->pose(t.seconds()); };
  mover.parts.push_back(
      {scene.shape("dog",
                   [] {
                     Mesh mesh;
                     mesh.add_ellipsoid({0, 0, 0.5}, {0.36, 0.13, 0.15}, 7, Material::cloth);
                     mesh.add_ellipsoid({0.45, 0, 0.66}, {0.16, 0.08, 0.09}, 6, Material::cloth);
                     mesh.add_frustum({-0.34, 0, 0.55}, 0.03, {-0.6, 0, 0.72}, 0.015, 5, Material::cloth);
                     return mesh;
                   }),
       nullptr});
  const auto leg = scene.shape("dog leg", [] { return limb(0.42, 0.05, 0.03, Material::cloth); });
  for (int i = 0; i < 4; ++i) {
    const Vector3d joint(i < 2 ? 0.25 : -0.25, i % 2 == 0 ? 0.09 : -0.09, 0.44);
    add_swinging(mover, track, leg, joint, 0.45, 0.7, i == 0 || i == 3 ? 0 : std::numbers::pi);
  }
  scene.add(std::move(mover));
}

void add_bird(SceneBuilder& scene, Motion T_0b, double flaps_hz) {
  Mover mover;
  mover.object_class = ObjectClass::bird;
  mover.radius_m = 1;
  mover.T_0b = std::move(T_0b);
  mover.parts.push_back(
      {scene.shape("bird",
                   [] {
                     Mesh mesh;
                     mesh.add_ellipsoid({0, 0, 0}, {0.28, 0.09, 0.09}, 6, Material::cloth);
                     mesh.add_ellipsoid({0.3, 0, 0.04}, {0.09, 0.06, 0.06}, 5, Material::cloth);
                     return mesh;
                   }),
       nullptr});
  for (const double side : {-1.0, 1.0}) {
    const auto wing = scene.shape(side > 0 ? "left wing" : "right wing", [side] {
      Mesh mesh;
      mesh.add_quad({0.16, 0, 0}, {-0.14, 0, 0}, {-0.1, side * 0.7, 0}, {0.06, side * 0.7, 0},
                    Material::cloth);
      return mesh;
    });
    mover.parts.push_back({wing, [side, flaps_hz](Time t) {
                             const double angle =
                                 0.6 * std::sin(2 * std::numbers::pi * flaps_hz * t.seconds()) * side;
                             return SE3(so3_exp({angle, 0, 0}), {0, side * 0.05, 0.03});
                           }});
  }
  scene.add(std::move(mover));
}

void add_drone(SceneBuilder& scene, Motion T_0b) {
  Mover mover;
  mover.object_class = ObjectClass::drone;
  mover.radius_m = 1;
  mover.T_0b = std::move(T_0b);
  mover.parts.push_back(
      {scene.shape("drone",
                   [] {
                     Mesh mesh;
                     mesh.add_box({-0.2, -0.15, -0.08}, {0.2, 0.15, 0.08}, Material::metal);
                     for (const double x : {-0.4, 0.4}) {
                       for (const double y : {-0.4, 0.4}) {
                         mesh.add_frustum({0, 0, 0}, 0.03, {x, y, 0.05}, 0.03, 5, Material::metal);
                         mesh.add_frustum({x, y, 0.08}, 0.22, {x, y, 0.1}, 0.22, 10, Material::metal);
                       }
                     }
                     return mesh;
                   }),
       nullptr});
  scene.add(std::move(mover));
}

void add_ball(SceneBuilder& scene, Motion T_0b, double radius_m) {
  Mover mover;
  mover.object_class = ObjectClass::ball;
  mover.radius_m = 2 * radius_m;
  mover.T_0b = std::move(T_0b);
  mover.parts.push_back(
      {scene.shape(fmt::format("ball {}", radius_m),
                   [radius_m] {
                     Mesh mesh;
                     mesh.add_ellipsoid({0, 0, 0}, Vector3d::Constant(radius_m), 10, Material::paint);
                     return mesh;
                   }),
       nullptr});
  scene.add(std::move(mover));
}

}  // namespace mapless
