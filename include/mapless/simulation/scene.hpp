#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <mapless/simulation/world.hpp>
#include <mapless/trajectory/trajectory.hpp>

namespace mapless::inline v1 {

/// What decides a scene. A longer duration of the same seed continues the shorter one.
struct SceneOptions {
  std::uint64_t seed = 1;
  double duration_s = 10;  ///< from time 0, at most kMaxSceneDuration_s
  /// Whether the world frame is turned by an arbitrary rotation (of the seed), so that its z means nothing.
  bool arbitrary_world = true;
};
inline constexpr double kMaxSceneDuration_s = 600;

/// A place with all that moves in it, and the way a sensor takes through it.
struct Scene {
  std::string name;
  WorldDescription world;  ///< in a level frame 0: z up
  /// Of the sensor in that frame at 200 Hz, from shortly before time 0 until shortly after the duration.
  std::vector<TimedPose> poses;
  SE3 T_w0;  ///< level frame to the world frame that is told to others

  /// Poses in the world frame, T_vw.
  [[nodiscard]] std::vector<TimedPose> poses_in_world() const;
};

}  // namespace mapless
