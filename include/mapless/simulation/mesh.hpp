#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include <mapless/core/se3.hpp>

namespace mapless::inline v1 {

/// Material of a surface; determines its diffuse reflectivity and the chance of a faulty return.
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

/// Diffuse reflectivity at a lidar's wavelength, 0 to 1.
[[nodiscard]] float reflectivity(Material material);

/// A triangle mesh; every triangle has one material and reflects on both sides. Coordinates in metres, in the
/// frame s of the shape. The functions that add to it throw ParameterError for an argument out of bounds.
struct Mesh {
  std::vector<Eigen::Vector3f> vertices;
  std::vector<Eigen::Matrix<std::uint32_t, 3, 1>> triangles;
  std::vector<Material> materials;  ///< of each triangle

  void add_triangle(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c, Material m);
  /// A quadrilateral; its corners in order along its outline.
  void add_quad(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                const Eigen::Vector3d& d, Material m);
  /// A box with edges parallel to the axes.
  void add_box(const Eigen::Vector3d& lowest, const Eigen::Vector3d& highest, Material m);
  /// A frustum from `base` to `tip` whose cross-section is a regular polygon of `sides` >= 3, closed at both
  /// ends. Radii at least 0; base and tip differ.
  void add_frustum(const Eigen::Vector3d& base, double base_radius_m, const Eigen::Vector3d& tip,
                   double tip_radius_m, int sides, Material m);
  /// A convex polygon in the x-z plane (at least three points (x, z) in order), extruded from y =
  /// -half_width_m to +half_width_m.
  void add_extrusion(const std::vector<Eigen::Vector2d>& outline_xz, double half_width_m, Material m);
  /// An ellipsoid of `rings` x 2 `rings` facets, rings >= 2.
  void add_ellipsoid(const Eigen::Vector3d& centre, const Eigen::Vector3d& radii_m, int rings, Material m);
  /// Every triangle of `other`, transformed to the frame of this mesh.
  void append(const Mesh& other, const SE3& T_here_other);
};

}  // namespace mapless
