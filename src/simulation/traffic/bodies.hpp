#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "simulation/scene_builder.hpp"
#include "simulation/traffic/road_user.hpp"

namespace mapless::inline v1 {

/// Adds a mover for each of `users` from index `first` on; it follows the track of the same index.
void add_movers(SceneBuilder& scene, const std::vector<RoadUser>& users,
                const std::vector<std::shared_ptr<const Track>>& tracks, std::size_t first);

}  // namespace mapless
