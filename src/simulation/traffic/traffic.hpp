#pragma once

/// @file
/// Folder traffic: how road users move. In go their paths and the junctions; out come one track per user and
/// the movers that follow these tracks. The folder knows paths and bodies, not scenes.

#include <cstdint>
#include <memory>
#include <vector>

#include "simulation/traffic/road_user.hpp"

namespace mapless::inline v1 {

/// Simulates the users from time 0 to `duration_s` in steps of Track::kStep_s and returns one track per user.
/// Vehicles follow the vehicle ahead (intelligent driver model, Treiber et al., Phys. Rev. E 62, 2000), slow
/// down in bends, obey traffic lights, yield to oncoming traffic when they turn left and to pedestrians on
/// the street, and keep junctions clear. Pedestrians wait for green, evade each other, and pause at random. A
/// longer duration continues a shorter one.
[[nodiscard]] std::vector<std::shared_ptr<const Track>> drive_all(const std::vector<RoadUser>& users,
                                                                  const std::vector<Junction>& junctions,
                                                                  const Terrain& terrain, double duration_s,
                                                                  std::uint64_t seed);

}  // namespace mapless
