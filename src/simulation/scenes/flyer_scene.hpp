#pragma once

#include <cstdint>

#include "simulation/scene_builder.hpp"
#include "simulation/traffic/road_user.hpp"

namespace mapless::inline v1 {

/// A hill top with flyers before the sky.
struct HillPlan {
  double fall_per_m = 0.0022;  ///< the ground falls by this times the square of the distance [1/m]
  int flyers = 10;
  int bushes = 14;
  double way_m = 6;  ///< radius of the way of the walker with the sensor

  [[nodiscard]] Terrain terrain() const;
};

/// Ground, bushes and flyers.
void build_hill(const HillPlan& plan, SceneBuilder& scene, std::uint64_t seed);
/// The walker with the sensor, alone on the hill.
[[nodiscard]] RoadUser hill_walker(const HillPlan& plan);

}  // namespace mapless
