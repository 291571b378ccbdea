#pragma once

#include <memory>

#include "simulation/scene_builder.hpp"
#include "simulation/traffic/path.hpp"

namespace mapless::inline v1 {

/// Each adds a mover that follows the track; the planted foot of a walker does not move.
void add_person(SceneBuilder& scene, int variant, const std::shared_ptr<const Track>& track);
void add_cyclist(SceneBuilder& scene, ObjectClass c, const std::shared_ptr<const Track>& track);
void add_dog(SceneBuilder& scene, const std::shared_ptr<const Track>& track);
/// Things that fly where `T_0b` takes them.
void add_bird(SceneBuilder& scene, Motion T_0b, double flaps_hz);
void add_drone(SceneBuilder& scene, Motion T_0b);
void add_ball(SceneBuilder& scene, Motion T_0b, double radius_m);

/// Where the two links (each `link_m`) of a leg in the x-z plane are: rotations about y (positive swings -z
/// towards -x) of the upper and of the lower link, and the joint. `hip` and `foot` as (x, z).
struct LegPose {
  double upper_rad, lower_rad;
  Eigen::Vector2d knee;
};
[[nodiscard]] LegPose bend_leg(const Eigen::Vector2d& hip, const Eigen::Vector2d& foot, double link_m);
/// Where a walker's foot is relative to his hip's ground point (ahead, up), `distance_m` along the way. In
/// the first half of the stride it stands still on the ground.
[[nodiscard]] Eigen::Vector2d foot_of_walker(double distance_m, double stride_m, bool left);

}  // namespace mapless
