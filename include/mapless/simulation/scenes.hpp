#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <mapless/simulation/scene.hpp>

namespace mapless::inline v1 {

/// Throws ParameterError listing the names for a scene that is not known, and for a duration out of range.
[[nodiscard]] Scene make_scene(std::string_view name, const SceneOptions& options);
[[nodiscard]] const std::vector<std::string>& scene_names();

}  // namespace mapless
