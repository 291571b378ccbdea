#include "simulation/scenes/random/carrier.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "simulation/scenes/random/draws.hpp"
#include "simulation/scenes/rings.hpp"
#include "simulation/scenes/sensor_poses.hpp"
#include "simulation/traffic/vehicles.hpp"

namespace mapless::inline v1 {
namespace {

using Eigen::Vector3d;
using Kind = Carrier::Kind;

// Where sensors are mounted on a vehicle [m]: on the roof of a car, a van or a bus, on the cab of a truck,
// before its box.
Vector3d draw_place_on(RandomSequence& random, ObjectClass vehicle) {
  const double aside = random.uniform(-0.5, 0.5);
  const double above = random.uniform(0.2, 0.6);
  switch (vehicle) {
    case ObjectClass::van:
      return {random.uniform(-1.5, 1.2), aside, 2.3 + above};
    case ObjectClass::truck:
      return {random.uniform(2.9, 4.1), 2 * aside, 2.9 + above};
    case ObjectClass::bus:
      return {random.uniform(-4, 5), 2 * aside, 3.35 + above};
    default:
      return {random.uniform(-1, 0.3), aside, 1.48 + above};
  }
}

// Level, by up to 8 degrees, or by 20 to 90 degrees.
SE3 draw_mount(RandomSequence& random, const Vector3d& place) {
  const double angle = random.uniform(0, kTurn);
  const double tilt = draw_one<double>(
      random, {{0, 0.45}, {random.uniform(0, 0.14), 0.35}, {random.uniform(0.35, 1.6), 0.2}});
  const Eigen::Matrix3d turned = rotation_z(random.chance(0.3) ? random.uniform(0, kTurn) : 0);
  return {so3_exp(tilt * Vector3d(std::cos(angle), std::sin(angle), 0)) * turned, place};
}

// A platform on wheels with a mast for the sensor and a handle behind it.
Mesh robot(double length_m, double sensor_m) {
  Mesh mesh;
  const double half = length_m / 2;
  const double top = std::min(0.45, sensor_m - 0.2);
  mesh.add_box({-half, -0.3, 0.12}, {half, 0.3, top}, Material::paint);
  mesh.add_frustum({0, 0, top}, 0.03, {0, 0, sensor_m - 0.08}, 0.03, 6, Material::metal);
  for (const double y : {-0.25, 0.25})
    mesh.add_frustum({-half, y, top}, 0.025, {-half, y, 1.5}, 0.025, 6, Material::metal);
  mesh.add_box({-half - 0.03, -0.28, 1.47}, {-half + 0.03, 0.28, 1.53}, Material::dark_paint);
  return mesh;
}

SE3 flown(const Track& track, double height_m, double t_s) {
  const SE3 below = track.pose(t_s);
  const auto ahead = below.rotation().col(0);
  const double v = track.speed(t_s);
  const Vector3d up(0, 0, height_m * (1 + 0.12 * std::sin(0.5 * t_s)));
  const Vector3d turned(0.03 * std::sin(2.3 * t_s), 0.02 * v + 0.03 * std::sin(1.7 * t_s + 1),
                        0.3 * std::sin(0.4 * t_s));
  return SE3(rotation_z(std::atan2(ahead.y(), ahead.x())) * so3_exp(turned), below.translation() + up);
}

}  // namespace

Carrier draw_carrier(RandomSequence& random, Kind kind) {
  Carrier carrier;
  carrier.kind = kind;
  carrier.vehicle = draw_one<ObjectClass>(
      random,
      {{ObjectClass::car, 0.6}, {ObjectClass::van, 0.2}, {ObjectClass::truck, 0.1}, {ObjectClass::bus, 0.1}});
  carrier.variant = random.index(12);
  carrier.length_m = random.uniform(0.7, 2.4);
  carrier.in_view = random.chance(0.6);
  carrier.shake = random.uniform(0.1, 1);
  switch (kind) {
    case Kind::vehicle:
      carrier.T_bv = draw_mount(random, draw_place_on(random, carrier.vehicle));
      break;
    case Kind::robot:
      carrier.speed_mps = random.uniform(0.5, 2.2);
      carrier.T_bv = draw_mount(random, {0, 0, random.uniform(0.45, 1.4)});
      break;
    case Kind::tripod:  // above all heads
      carrier.T_bv = draw_mount(random, {0, 0, random.uniform(2.1, 4)});
      break;
    case Kind::drone:
      carrier.speed_mps = random.uniform(0.5, 8);
      carrier.height_m = random.uniform(14, 30);  // above trees and most roofs
      carrier.T_bv = draw_mount(random, Vector3d::Zero());
      break;
    case Kind::hand:
    case Kind::back:
      carrier.speed_mps = random.uniform(0.6, 1.8);
      carrier.height_m = random.uniform(1.85, 2.2);
      break;
  }
  return carrier;
}

std::function<SE3(double t_s)> body_motion(const Carrier& carrier,
                                           const std::shared_ptr<const Track>& track) {
  switch (carrier.kind) {
    case Kind::hand:
      return [track, shake = carrier.shake](double t) { return hand_held(*track, shake, t); };
    case Kind::back:
      return [track, height = carrier.height_m](double t) { return carried(*track, height, t); };
    case Kind::tripod:
      return [pose = track->pose(0)](double) { return pose; };
    case Kind::drone:
      return [track, height = carrier.height_m](double t) { return flown(*track, height, t); };
    default:
      return [track](double t) { return ridden(*track, t); };
  }
}

void add_carrier(SceneBuilder& scene, const Carrier& carrier, const std::function<SE3(double t_s)>& T_0b) {
  const bool vehicle = carrier.kind == Kind::vehicle;
  if (!carrier.in_view || (!vehicle && carrier.kind != Kind::robot)) return;
  Mover mover;
  mover.object_class = vehicle ? carrier.vehicle : ObjectClass::furniture;
  mover.radius_m = (vehicle ? body_length(carrier.vehicle) : carrier.length_m) / 2 + 3;
  mover.carries_sensor = true;
  mover.T_0b = [T_0b](Time t) { return T_0b(t.seconds()); };
  mover.parts.push_back({scene.shape("carrier",
                                     [&] {
                                       return vehicle
                                                  ? vehicle_body(carrier.vehicle, carrier.variant)
                                                  : robot(carrier.length_m, carrier.T_bv.translation().z());
                                     }),
                         nullptr});
  scene.add(std::move(mover));
}

}  // namespace mapless
