#pragma once

#include <memory>

#include "simulation/scene_builder.hpp"
#include "simulation/traffic/path.hpp"

namespace mapless::inline v1 {

/// Each adds a mover that follows the track; the planted foot of a walker does not move.
void add_person(SceneBuilder& scene, int variant, const std::shared_ptr<const Track>& track);
void add_cyclist(SceneBuilder& scene, ObjectClass c, const std::shared_ptr<const Track>& track);
void add_dog(SceneBuilder& scene, const std::shared_ptr<const Track>& track);
/// Each adds a flying mover with the motion `T_0b`.
void add_bird(SceneBuilder& scene, Motion T_0b, double flaps_hz);
void add_drone(SceneBuilder& scene, Motion T_0b);
void add_ball(SceneBuilder& scene, Motion T_0b, double radius_m);

/// Pose of a leg of two links of length `link_m` each in the x-z plane, from hip to foot, both (x, z) [m]:
/// rotations of the upper and the lower link about y (a positive angle turns -z towards -x), and the knee.
struct LegPose {
  double upper_rad, lower_rad;
  Eigen::Vector2d knee;
};
[[nodiscard]] LegPose bend_leg(const Eigen::Vector2d& hip, const Eigen::Vector2d& foot, double link_m);
/// Position of a walker's foot (forward, up) [m] relative to the ground point below the hip, after
/// `distance_m` of walking. In the first half of the stride the foot is planted: it does not move over the
/// ground.
[[nodiscard]] Eigen::Vector2d foot_of_walker(double distance_m, double stride_m, bool left);

}  // namespace mapless
