#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "simulation/traffic/path.hpp"
#include <mapless/simulation/scene.hpp>

namespace mapless::inline v1 {

/// Part of a pedestrian's path that crosses a street, from kerb to kerb, in metres along the path.
struct StreetCrossing {
  double from_m = 0, to_m = 0;
  std::size_t junction = 0;  ///< whose traffic lights apply
  bool along_x = true;       ///< walking along x, else along y
};

/// A vehicle, pedestrian or dog with its own path.
struct RoadUser {
  ObjectClass object_class = ObjectClass::car;
  std::shared_ptr<const Path> path;
  double start_m = 0;         ///< distance along the path at time 0
  double desired_speed = 10;  ///< [m/s]
  double wheelbase_m = 2.7;
  double stop_every_s = 0;  ///< mean time between pauses of 6 s of a pedestrian; 0: no pauses
  std::vector<StreetCrossing> crossings = {};  ///< of a pedestrian's path, in order
};

/// A junction with traffic lights: green alternates between traffic along x and along y.
struct Junction {
  Eigen::Vector2d centre;
  double half_size_m = 9;  ///< from the centre to the stop lines
  double offset_s = 0;     ///< phase of its light cycle at time 0
};

}  // namespace mapless
