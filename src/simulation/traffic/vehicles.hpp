#pragma once

#include <memory>

#include "simulation/scene_builder.hpp"
#include "simulation/traffic/path.hpp"

namespace mapless::inline v1 {

/// Outer dimensions of a road user of this class [m].
[[nodiscard]] double body_length(ObjectClass c);
[[nodiscard]] double body_width(ObjectClass c);

/// The body of a vehicle without its wheels. Frame: x forward, z up, origin on the ground below its centre.
/// `variant` selects one of several shapes and paints.
[[nodiscard]] Mesh vehicle_body(ObjectClass c, int variant);

/// Adds a vehicle that follows the track, with turning wheels.
void add_vehicle(SceneBuilder& scene, ObjectClass c, int variant, const std::shared_ptr<const Track>& track);
/// Adds a parked vehicle, with its wheels.
void park_vehicle(SceneBuilder& scene, ObjectClass c, int variant, const SE3& T_0b);

}  // namespace mapless
