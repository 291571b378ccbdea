#pragma once

#include "simulation/random.hpp"
#include "simulation/scene_builder.hpp"
#include "simulation/traffic/path.hpp"

namespace mapless::inline v1 {

/// A patch of ground `lift_m` above the terrain, in cells of `cell_m`, between the corners low and high.
[[nodiscard]] Mesh ground_patch(const Eigen::Vector2d& low, const Eigen::Vector2d& high, double lift_m,
                                double cell_m, const Terrain& terrain, Material m);
/// The vertical edge around such a patch, from the terrain up to `lift_m` (a kerb).
[[nodiscard]] Mesh patch_edge(const Eigen::Vector2d& low, const Eigen::Vector2d& high, double lift_m,
                              double cell_m, const Terrain& terrain, Material m);

/// A house with its front at y = 0, facing -y, x from -width/2 to width/2, back at y = depth.
[[nodiscard]] Mesh house(RandomSequence& random, double width_m, double depth_m, int floors);
/// A tree of trunk, branches and single leaves, on the z axis.
[[nodiscard]] Mesh tree(RandomSequence& random, double height_m);
[[nodiscard]] Mesh bush(RandomSequence& random);
[[nodiscard]] Mesh lamp_post();
[[nodiscard]] Mesh traffic_light();
[[nodiscard]] Mesh street_sign();
/// Fences along x from 0 to length.
[[nodiscard]] Mesh picket_fence(double length_m);
[[nodiscard]] Mesh wire_fence(double length_m);

/// Places scenery on the terrain: each function puts one of several shapes at p [m], turned by `angle` [rad]
/// about z.
class Scenery {
 public:
  Scenery(SceneBuilder& scene, Terrain terrain, std::uint64_t seed)
      : scene_(scene), terrain_(std::move(terrain)), seed_(seed) {}
  void put_tree(const Eigen::Vector2d& p, int variant, double angle) const;
  void put_bush(const Eigen::Vector2d& p, int variant, double angle) const;
  /// A house with the centre of its front at `front`.
  void put_house(const Eigen::Vector2d& front, double angle, int variant) const;
  [[nodiscard]] static double house_width(int variant) { return 9.0 + 2.5 * (variant % 4); }
  void put_lamp(const Eigen::Vector2d& p, double angle) const;
  void put_traffic_light(const Eigen::Vector2d& p, double angle) const;
  void put_sign(const Eigen::Vector2d& p, double angle) const;
  /// A fence of 6 m from p in the direction `angle`.
  void put_fence(const Eigen::Vector2d& p, double angle, bool wire) const;
  void put_parked(const Eigen::Vector2d& p, double angle, ObjectClass c, int variant) const;
  [[nodiscard]] const Terrain& terrain() const { return terrain_; }
  [[nodiscard]] SceneBuilder& scene() const { return scene_; }

 private:
  [[nodiscard]] SE3 upright(const Eigen::Vector2d& p, double angle) const;
  SceneBuilder& scene_;
  Terrain terrain_;
  std::uint64_t seed_;
};

}  // namespace mapless
