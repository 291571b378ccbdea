#pragma once

#include <memory>

#include "simulation/scene_builder.hpp"
#include "simulation/traffic/path.hpp"

namespace mapless::inline v1 {

/// Outer size of a vehicle of this class [m].
[[nodiscard]] double body_length(ObjectClass c);
[[nodiscard]] double body_width(ObjectClass c);

/// The body of a vehicle (x ahead, z up, origin on the ground below its middle), without its wheels.
/// `variant` chooses one of a few forms and paints.
[[nodiscard]] Mesh vehicle_body(ObjectClass c, int variant);

/// Adds a vehicle that follows the track, with turning wheels.
void add_vehicle(SceneBuilder& scene, ObjectClass c, int variant, const std::shared_ptr<const Track>& track);
/// A vehicle that stands still, wheels and all.
void park_vehicle(SceneBuilder& scene, ObjectClass c, int variant, const SE3& T_0b);

}  // namespace mapless
