#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include <mapless/core/se3.hpp>
#include <mapless/core/time.hpp>

namespace mapless::test {

enum class ToyShape {
  plane,    ///< the body's z = 0, without end
  box,      ///< size: half extents
  sphere,   ///< size.x: radius
  cylinder  ///< size.x: radius, size.z: half height, closed, axis along the body's z
};

/// A solid that keeps its velocity, and turns about the world's z through its own origin.
struct ToyBody {
  ToyShape shape = ToyShape::box;
  SE3 T_0b;  ///< at time 0
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_0 = Eigen::Vector3d::Zero();  ///< [m/s]
  double yaw_rate = 0;                                   ///< [rad/s], counter-clockwise
  std::uint16_t object = 0;                              ///< written to the labels of its moving points

  [[nodiscard]] bool stands() const { return velocity_0.isZero(0) && yaw_rate == 0; }
  [[nodiscard]] SE3 pose_at(Time t) const;
  /// Speed of the body's material at a point of the world [m/s].
  [[nodiscard]] double speed_at(const Eigen::Vector3d& p_0, Time t) const;
};

using ToyWorld = std::vector<ToyBody>;

[[nodiscard]] ToyBody toy_ground(double height_m);
/// Upright: `centre` and half extents in the world, turned by `yaw_rad` about its own vertical.
[[nodiscard]] ToyBody toy_box(const Eigen::Vector3d& centre, const Eigen::Vector3d& half_size,
                              double yaw_rad = 0);
[[nodiscard]] ToyBody toy_sphere(const Eigen::Vector3d& centre, double radius_m);
[[nodiscard]] ToyBody toy_cylinder(const Eigen::Vector3d& centre, double radius_m, double half_height_m);

/// Distance along the ray from `origin_b` towards the unit vector `direction_b`, both in the body's frame, to
/// where it first enters the body; none where it does not, or starts inside.
[[nodiscard]] std::optional<double> intersect(const ToyBody& body, const Eigen::Vector3d& origin_b,
                                              const Eigen::Vector3d& direction_b);

/// C v, element by element: every ray needs it several times, and the sanitizers make Eigen's product slow.
[[nodiscard]] inline Eigen::Vector3d turned(const Eigen::Matrix3d& C, const Eigen::Vector3d& v) {
  const double* c = C.data();  // column by column
  const double x = v.x(), y = v.y(), z = v.z();
  return {c[0] * x + c[3] * y + c[6] * z, c[1] * x + c[4] * y + c[7] * z, c[2] * x + c[5] * y + c[8] * z};
}
[[nodiscard]] inline Eigen::Vector3d moved(const SE3& T, const Eigen::Vector3d& p) {
  return turned(T.rotation(), p) + T.translation();
}

/// A body where it is at one instant.
struct PlacedBody {
  SE3 T_b0;
  Eigen::Vector3d centre_0;  ///< [m]
  double radius_m;           ///< of a sphere around it; infinite for a plane
};
[[nodiscard]] PlacedBody placed(const ToyBody& body, Time t);

struct ToyHit {
  double range_m;
  std::size_t body;
};
/// The first body that the ray towards the unit vector `direction_0` enters, with each body where `places`
/// says.
[[nodiscard]] std::optional<ToyHit> first_hit(const ToyWorld& world, const std::vector<PlacedBody>& places,
                                              const Eigen::Vector3d& origin_0,
                                              const Eigen::Vector3d& direction_0);

}  // namespace mapless::test
