#pragma once

/// @file
/// Folder random: a scene whose place, traffic and sensor mount are drawn from the seed. In go a sequence of
/// random numbers and the carrier of the sensor; out come the scenery of one kind of place, its road users
/// and their junctions. All draws are independent of the duration.

#include <cstdint>
#include <vector>

#include "simulation/random.hpp"
#include "simulation/scene_builder.hpp"
#include "simulation/scenes/random/carrier.hpp"
#include "simulation/traffic/road_user.hpp"

namespace mapless::inline v1 {

/// A drawn place. The scenery is in the builder.
struct Place {
  Terrain terrain;
  std::vector<Junction> junctions;
  std::vector<RoadUser> users;  ///< the first carries the sensor
};

/// A town on a grid of streets.
[[nodiscard]] Place draw_town(SceneBuilder& scene, RandomSequence& random, const Carrier& carrier,
                              std::uint64_t seed);
/// One road round a ring, from an alley between houses to a motorway.
[[nodiscard]] Place draw_road(SceneBuilder& scene, RandomSequence& random, const Carrier& carrier,
                              std::uint64_t seed);
/// Open or roofed ground on which people walk: a park, a wood, a yard with parked cars, a hall.
[[nodiscard]] Place draw_grounds(SceneBuilder& scene, RandomSequence& random, const Carrier& carrier,
                                 std::uint64_t seed, double duration_s);
/// A tunnel, from a corridor to a vault.
[[nodiscard]] Place draw_tunnel(SceneBuilder& scene, RandomSequence& random, std::uint64_t seed);
/// A hill top with flyers.
[[nodiscard]] Place draw_hill(SceneBuilder& scene, RandomSequence& random, std::uint64_t seed);

}  // namespace mapless
