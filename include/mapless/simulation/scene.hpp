#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <mapless/simulation/world.hpp>
#include <mapless/trajectory/trajectory.hpp>

namespace mapless::inline v1 {

/// Options of make_scene. The same seed with a longer duration gives the same motion, continued.
struct SceneOptions {
  std::uint64_t seed = 1;
  double duration_s = 10;  ///< from time 0; above 0 and at most kMaxSceneDuration_s
  /// Rotates the world frame by a random rotation (of the seed), so that its z axis is not vertical.
  bool arbitrary_world = true;
};
/// The paths of all movers are as long as this duration needs [s].
inline constexpr double kMaxSceneDuration_s = 600;

/// A place with everything that moves in it, and the poses of a sensor that moves through it.
struct Scene {
  std::string name;
  WorldDescription world;  ///< in the level frame 0: z up
  /// Of the sensor with respect to frame 0, at 200 Hz, from 0.1 s before time 0 to 0.1 s after the duration.
  std::vector<TimedPose> poses;
  SE3 T_w0;  ///< world frame w of the recording from the level frame 0

  /// The poses with respect to the world frame of the recording: T_vw.
  [[nodiscard]] std::vector<TimedPose> poses_in_world() const;
};

/// Builds the scene of this name (scene_names()). Throws ParameterError for an unknown name, listing the
/// names, and for a duration out of bounds.
[[nodiscard]] Scene make_scene(std::string_view name, const SceneOptions& options);
/// Names of all scenes, in a fixed order.
[[nodiscard]] const std::vector<std::string>& scene_names();

}  // namespace mapless
