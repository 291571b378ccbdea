#pragma once

/// @file
/// Folder scenes: the named scenes. In go seed and duration; out come the world and the poses of the sensor.
/// Each function fills `world` and `poses` of a Scene; make_scene adds name and world frame.

#include <mapless/simulation/scene.hpp>

namespace mapless::inline v1 {

[[nodiscard]] Scene town1(const SceneOptions& options);
[[nodiscard]] Scene town2(const SceneOptions& options);
[[nodiscard]] Scene tilted(const SceneOptions& options);
[[nodiscard]] Scene crossing(const SceneOptions& options);
[[nodiscard]] Scene highway(const SceneOptions& options);
[[nodiscard]] Scene forest(const SceneOptions& options);
[[nodiscard]] Scene tunnel(const SceneOptions& options);
[[nodiscard]] Scene flyer(const SceneOptions& options);
/// A place drawn from the seed (random/places.hpp).
[[nodiscard]] Scene random_scene(const SceneOptions& options);

}  // namespace mapless
