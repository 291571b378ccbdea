#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>

#include "simulation/traffic/path.hpp"
#include <mapless/simulation/world.hpp>

namespace mapless::inline v1 {

/// Collects the shapes and objects of a scene. Shapes with a name are made once and shared.
class SceneBuilder {
 public:
  std::size_t shape(const std::string& name, const std::function<Mesh()>& make);
  void place(std::size_t shape, const SE3& T_0s, ObjectClass object_class, bool numbered = false);
  /// Adds the mover and gives it the next number.
  void add(Mover mover);
  [[nodiscard]] WorldDescription take() { return std::move(world_); }

 private:
  WorldDescription world_;
  std::map<std::string, std::size_t> shapes_;
  int last_id_ = 0;
};

/// Outer size of a vehicle of this class [m].
[[nodiscard]] double body_length(ObjectClass c);
[[nodiscard]] double body_width(ObjectClass c);

/// The body of a vehicle (x ahead, z up, origin on the ground below its middle), without its wheels.
/// `variant` chooses one of a few forms and paints.
[[nodiscard]] Mesh vehicle_body(ObjectClass c, int variant);

/// Each adds a mover that follows the track: turning wheels; legs whose planted foot stands still.
void add_vehicle(SceneBuilder& scene, ObjectClass c, int variant, const std::shared_ptr<const Track>& track);
void add_person(SceneBuilder& scene, int variant, const std::shared_ptr<const Track>& track);
void add_cyclist(SceneBuilder& scene, ObjectClass c, const std::shared_ptr<const Track>& track);
void add_dog(SceneBuilder& scene, const std::shared_ptr<const Track>& track);
/// Things that fly where `T_0b` takes them.
void add_bird(SceneBuilder& scene, Motion T_0b, double flaps_hz);
void add_drone(SceneBuilder& scene, Motion T_0b);
void add_ball(SceneBuilder& scene, Motion T_0b, double radius_m);
/// A vehicle that stands still, wheels and all.
void park_vehicle(SceneBuilder& scene, ObjectClass c, int variant, const SE3& T_0b);

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
