#pragma once

#include "simulation/scenes/scenery.hpp"
#include "simulation/traffic/road_user.hpp"
#include <mapless/simulation/scene.hpp>

namespace mapless::inline v1 {

/// A town on a grid of nx by ny junctions.
struct TownPlan {
  int nx = 4, ny = 3;
  double dx_m = 180, dy_m = 160;  ///< between junctions
  double half_road_m = 5.5;       ///< from the centre line to the kerb, parked cars included
  double lane_m = 1.75;           ///< from the centre line of the road to that of a lane
  double pavement_m = 3;          ///< width
  double front_garden_m = 4;      ///< from pavement to houses
  double fences = 0.3;            ///< share of the frontage with a fence
  double parked = 0.5;            ///< share of the parking places that are taken
  double speed = 12;              ///< of cars [m/s]
  double hills_m = 1.6;           ///< amplitude of the terrain
  // Numbers of road users.
  int cars = 34, vans = 5, trucks = 3, buses = 5, motorcycles = 3, cyclists = 8;
  int people = 70, dogs = 8;

  [[nodiscard]] Eigen::Vector2d junction(int i, int j) const { return {i * dx_m, j * dy_m}; }
  [[nodiscard]] std::size_t junction_number(int i, int j) const {
    return static_cast<std::size_t>(i * ny + j);
  }
  /// From the centre of a junction to the stop lines, where turns begin.
  [[nodiscard]] double turn_m() const { return half_road_m + 5; }
  [[nodiscard]] Terrain terrain() const;
  [[nodiscard]] std::vector<Junction> junctions() const;
  /// Total length of all streets.
  [[nodiscard]] double road_length_m() const { return (nx - 1) * ny * dx_m + nx * (ny - 1) * dy_m; }
};

[[nodiscard]] TownPlan town1_plan();
[[nodiscard]] TownPlan town2_plan();

/// Streets, pavements, houses, trees, furniture and parked cars.
void build_town(const TownPlan& plan, const Scenery& scenery, std::uint64_t seed);

/// A random path of `length_m` through the streets, `aside_m` to the right of their centre lines.
[[nodiscard]] std::shared_ptr<const Path> random_drive(const TownPlan& plan, RandomSequence& random,
                                                       double aside_m, double length_m);
/// A pedestrian on the pavements who crosses streets at junctions.
[[nodiscard]] RoadUser random_walker(const TownPlan& plan, RandomSequence& random, double length_m);
/// All road users of the town; the vehicle with the sensor is the first if `with_ego`.
[[nodiscard]] std::vector<RoadUser> town_people(const TownPlan& plan, const SceneOptions& options,
                                                bool with_ego);

}  // namespace mapless
