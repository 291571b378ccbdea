#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "simulation/scene_builder.hpp"
#include "simulation/traffic/road_user.hpp"

namespace mapless::inline v1 {

/// Adds everyone of `users` from number `first` on with his track.
void add_users(SceneBuilder& scene, const std::vector<RoadUser>& users,
               const std::vector<std::shared_ptr<const Track>>& tracks, std::size_t first);

}  // namespace mapless
