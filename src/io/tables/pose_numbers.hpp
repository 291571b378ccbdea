#pragma once

#include <array>

#include <Eigen/Geometry>

#include <mapless/core/se3.hpp>

namespace mapless::inline v1 {

/// Position x y z [m] and unit quaternion x y z w of a pose, w at least 0: the order of a TUM row.
[[nodiscard]] inline std::array<double, 7> pose_numbers(const SE3& T_0v) {
  const Eigen::Vector3d& p = T_0v.translation();
  Eigen::Quaterniond q(T_0v.rotation());
  q.normalize();
  if (q.w() < 0) q.coeffs() = -q.coeffs();
  return {p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w()};
}

}  // namespace mapless
