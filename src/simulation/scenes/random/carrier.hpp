#pragma once

#include <functional>
#include <memory>

#include "simulation/random.hpp"
#include "simulation/scene_builder.hpp"
#include "simulation/traffic/path.hpp"

namespace mapless::inline v1 {

/// What carries the sensor. Frame b is that of its body.
struct Carrier {
  enum class Kind { vehicle, robot, hand, back, tripod, drone };
  Kind kind = Kind::vehicle;
  ObjectClass vehicle = ObjectClass::car;
  int variant = 0;         ///< of the vehicle's body
  double length_m = 1;     ///< of a robot
  bool in_view = false;    ///< the body of a vehicle or robot is part of the world
  double speed_mps = 1.2;  ///< desired; of a vehicle the place draws it
  double height_m = 1.9;   ///< of a sensor on a back, and of a drone, above the ground
  double shake = 1;        ///< of a sensor in a hand; 1: as in the scene `tunnel`
  SE3 T_bv;                ///< mount of all others

  /// Drones and tripods take no part in traffic.
  [[nodiscard]] bool in_traffic() const { return kind != Kind::tripod && kind != Kind::drone; }
  /// Takes part as a pedestrian.
  [[nodiscard]] bool on_foot() const { return in_traffic() && kind != Kind::vehicle; }
};

/// Draws mount, height, speed and body of a carrier of this kind.
[[nodiscard]] Carrier draw_carrier(RandomSequence& random, Carrier::Kind kind);
/// Its pose T_0b(t) along the track.
[[nodiscard]] std::function<SE3(double t_s)> body_motion(const Carrier& carrier,
                                                         const std::shared_ptr<const Track>& track);
/// Adds its body with this motion where it is in view.
void add_carrier(SceneBuilder& scene, const Carrier& carrier, const std::function<SE3(double t_s)>& T_0b);

}  // namespace mapless
