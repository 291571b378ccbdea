#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include <mapless/core/se3.hpp>

namespace mapless::inline v1 {

/// What a surface is made of, as far as a lidar can tell.
enum class Material : std::uint8_t {
  asphalt,
  earth,
  concrete,
  brick,
  foliage,
  wood,
  metal,
  paint,
  dark_paint,
  glass,
  cloth
};

/// Diffuse reflectivity, 0 to 1.
[[nodiscard]] float reflectivity(Material material);

/// Triangles, each of one material; both sides reflect. Metres, in the frame of the shape.
struct Mesh {
  std::vector<Eigen::Vector3f> vertices;
  std::vector<Eigen::Matrix<std::uint32_t, 3, 1>> triangles;
  std::vector<Material> materials;  ///< of each triangle

  void add_triangle(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c, Material m);
  /// Corners in order around the quadrilateral.
  void add_quad(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                const Eigen::Vector3d& d, Material m);
  /// Box along the axes.
  void add_box(const Eigen::Vector3d& lowest, const Eigen::Vector3d& highest, Material m);
  /// Frustum from `base` to `tip` with a regular polygon of `sides` for its section, closed at both ends.
  void add_frustum(const Eigen::Vector3d& base, double base_radius_m, const Eigen::Vector3d& tip,
                   double tip_radius_m, int sides, Material m);
  /// A polygon in the x-z plane (points (x, z) in order), extruded from y = -half_width to +half_width. The
  /// polygon must be convex.
  void add_extrusion(const std::vector<Eigen::Vector2d>& outline_xz, double half_width_m, Material m);
  /// Ellipsoid of `rings` x 2 rings facets.
  void add_ellipsoid(const Eigen::Vector3d& centre, const Eigen::Vector3d& radii_m, int rings, Material m);
  /// All of `other`, moved.
  void append(const Mesh& other, const SE3& T_here_other);
};

}  // namespace mapless
