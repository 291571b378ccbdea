#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "simulation/traffic/path.hpp"
#include <mapless/simulation/world.hpp>

namespace mapless::inline v1 {

/// Where a path on foot crosses a street, from kerb to kerb, by distance along it.
struct StreetCrossing {
  double from_m = 0, to_m = 0;
  std::size_t junction = 0;  ///< whose lights he obeys
  bool along_x = true;       ///< the way he walks
};

/// One who moves along a path of his own and gives way to others.
struct RoadUser {
  ObjectClass object_class = ObjectClass::car;
  std::shared_ptr<const Path> path;
  double start_m = 0;         ///< where on the path at time 0
  double desired_speed = 10;  ///< [m/s]
  double wheelbase_m = 2.7;
  double stop_every_s = 0;  ///< stops for a while now and then, on average once in so long; 0: never
  std::vector<StreetCrossing> crossings = {};  ///< of one on foot
};

/// A junction with lights: traffic along x and along y goes in turns.
struct Junction {
  Eigen::Vector2d centre;
  double half_size_m = 9;  ///< to the lines where vehicles wait
  double offset_s = 0;     ///< of its phase
};

}  // namespace mapless
