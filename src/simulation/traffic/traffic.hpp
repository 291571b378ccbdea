#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "simulation/traffic/road_user.hpp"

namespace mapless::inline v1 {

/// Moves the users from time 0 to `duration_s` in steps of Track::kStep_s: vehicles follow leaders
/// (intelligent driver model), slow down for bends, obey lights, give way to oncoming traffic as they turn
/// left and to people on the street, and keep junctions clear; people wait for their light, step aside for
/// each other and stop now and then. A longer duration continues a shorter one. One track each.
[[nodiscard]] std::vector<std::shared_ptr<const Track>> drive_all(const std::vector<RoadUser>& users,
                                                                  const std::vector<Junction>& junctions,
                                                                  const Terrain& terrain, double duration_s,
                                                                  std::uint64_t seed);

}  // namespace mapless
