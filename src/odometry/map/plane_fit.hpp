#pragma once

#include <algorithm>
#include <array>

#include <Eigen/Core>

namespace mapless::inline v1 {

/// A plane fitted to the points of one cube of the map, for one query point.
struct MapPlane {
  Eigen::Vector3d point_0;   ///< mean of the points [m]
  Eigen::Vector3d normal_0;  ///< unit length
  /// Variance of the distance of the query point from the plane [m^2]: the thickness of the points about the
  /// plane, and the uncertainty of the plane at the query point (method.md section 6, "Map").
  double variance;
  double normal_variance;  ///< of the tilt of the normal [rad^2], mean of both directions
};

/// Fewest points of a plane. Chosen: twice its degrees of freedom.
inline constexpr int kMinPlanePoints = 6;
/// Fewest lasers of a plane, over all scans. The points of one laser in one scan lie on a line. The lines of
/// one laser in several scans span a surface whose tilt is decided by the motion estimated between them: such
/// a plane confirms any motion, also a wrong one. Measured: with three lines of any laser, 11 of 41
/// recordings of a VLP-16 are lost; with two lasers, 2 (docs/notebook/odometry.md, "Planes of one laser").
inline constexpr int kMinPlaneLasers = 2;

/// Moments of the points of a cube, from its corner, so that their precision does not depend on the distance
/// from the origin.
struct PointSums {
  std::array<double, 3> first = {};
  std::array<double, 6> products = {};  // xx, xy, xz, yy, yz, zz
  int count = 0;

  /// Adds a point, or with sign -1 removes it. Axis by axis, in registers: with Eigen vectors each sum would
  /// pass through memory.
  void add(double x, double y, double z, int sign = 1) {
    const double sx = sign * x, sy = sign * y, sz = sign * z;
    first[0] += sx;
    first[1] += sy;
    first[2] += sz;
    products[0] += sx * x;
    products[1] += sx * y;
    products[2] += sx * z;
    products[3] += sy * y;
    products[4] += sy * z;
    products[5] += sz * z;
    count += sign;
  }
  void add(const PointSums& other, int sign = 1) {
    for (std::size_t i = 0; i < first.size(); ++i) first[i] += sign * other.first[i];
    for (std::size_t i = 0; i < products.size(); ++i) products[i] += sign * other.products[i];
    count += sign * other.count;
  }
};

/// Of one cache line: a query reads nothing else.
struct alignas(64) FittedPlane {
  Eigen::Vector3f mean = Eigen::Vector3f::Zero();  ///< from the corner of the cube [m]
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();
  Eigen::Vector3f middle = Eigen::Vector3f::Zero();  ///< direction of medium extent
  float thickness = 0;                               ///< variance across the plane [m^2]
  float uncertainty = 0;                             ///< variance of the plane at its mean [m^2]; 0: no plane
  float per_middle = 0, per_largest = 0;  ///< its growth with the square of the distance from the mean

  [[nodiscard]] bool exists() const { return uncertainty > 0; }
  /// MapPlane::variance for a point of the cube, given from its corner.
  [[nodiscard]] double variance_at(const Eigen::Vector3f& p) const {
    const Eigen::Vector3f d = p - mean;
    const float along_middle = d.dot(middle);
    const float across = d.dot(normal);
    const float along_largest_squared =
        std::max(0.F, d.squaredNorm() - along_middle * along_middle - across * across);
    return thickness + uncertainty + per_middle * along_middle * along_middle +
           per_largest * along_largest_squared;
  }
  [[nodiscard]] MapPlane in_world(const Eigen::Vector3d& corner_0, double variance) const {
    return {corner_0 + mean.cast<double>(), normal.cast<double>(), variance, (per_middle + per_largest) / 2};
  }
};

/// The least-squares plane of the points of a cube. It does not exist if they are fewer than kMinPlanePoints,
/// along one line or scattered in all directions, or if a face of the cube cuts through the noise of the
/// plane. `spanned`: one scan alone has hit the cube with two lasers. `sigma_m` is the expected noise of a
/// point; it enters the thickness with the weight of six points.
[[nodiscard]] FittedPlane fit_plane(const PointSums& sums, bool spanned, double cube_m, double sigma_m);

}  // namespace mapless
