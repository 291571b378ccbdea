#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <mapless/simulation/scene.hpp>

namespace mapless::inline v1 {

/// Builds the scene of this name (scene_names()). Throws ParameterError for an unknown name, listing the
/// names, and for a duration out of bounds.
[[nodiscard]] Scene make_scene(std::string_view name, const SceneOptions& options);
/// Names of all scenes, in a fixed order.
[[nodiscard]] const std::vector<std::string>& scene_names();

}  // namespace mapless
