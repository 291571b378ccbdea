#pragma once

#include <mapless/simulation/scene.hpp>

namespace mapless::inline v1 {

// Each fills the world and the poses of a scene; scenes.cpp has their names.
[[nodiscard]] Scene town1(const SceneOptions& options);
[[nodiscard]] Scene town2(const SceneOptions& options);
[[nodiscard]] Scene tilted(const SceneOptions& options);
[[nodiscard]] Scene crossing(const SceneOptions& options);
[[nodiscard]] Scene highway(const SceneOptions& options);
[[nodiscard]] Scene forest(const SceneOptions& options);
[[nodiscard]] Scene tunnel(const SceneOptions& options);
[[nodiscard]] Scene flyer(const SceneOptions& options);

}  // namespace mapless
