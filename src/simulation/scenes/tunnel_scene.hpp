#pragma once

#include <cstdint>
#include <vector>

#include "simulation/scene_builder.hpp"
#include "simulation/traffic/road_user.hpp"

namespace mapless::inline v1 {

/// A vaulted tunnel of 220 m along x. Lengths in metres.
struct TunnelPlan {
  double half_width_m = 3.6, height_m = 4.4;
  double swing_m = 6;         ///< of its middle to the sides, so that the ends are out of sight
  double hills_m = 0.8;       ///< amplitude of the floor
  double boxes = 0.4;         ///< share of the bays with a box at the wall
  int people = 21;            ///< one in eight of them a dog
  double sensor_way_m = 0.5;  ///< from the middle to the way of the walker with the sensor
  double first_way_m = 1.0, last_way_m = 2.4;  ///< from the middle to the ways of the others
  double stop_every_s = 40;                    ///< mean time between their pauses

  [[nodiscard]] Terrain terrain() const;
  /// The y coordinate of its middle at x.
  [[nodiscard]] double middle(double x) const;
};

/// Walls, ribs, pipes, lamps and boxes.
void build_tunnel(const TunnelPlan& plan, SceneBuilder& scene, std::uint64_t seed);
/// Its walkers; the first carries the sensor.
[[nodiscard]] std::vector<RoadUser> tunnel_people(const TunnelPlan& plan, std::uint64_t seed);

}  // namespace mapless
