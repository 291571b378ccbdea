#pragma once

#include <mapless/core/se3.hpp>
#include <mapless/odometry/odometry_update.hpp>

namespace mapless::inline v1 {

/// Adjoint of a transform: exp((Ad(T) xi)^) = T exp(xi^) T^-1.
[[nodiscard]] inline Matrix6d adjoint(const SE3& T) {
  Matrix6d out = Matrix6d::Zero();
  out.topLeftCorner<3, 3>() = T.rotation();
  out.bottomRightCorner<3, 3>() = T.rotation();
  out.topRightCorner<3, 3>() = hat(T.translation()) * T.rotation();
  return out;
}

/// Adjoint of the Lie algebra: curly_hat(a) b = -curly_hat(b) a.
[[nodiscard]] inline Matrix6d curly_hat(const Vector6d& a) {
  Matrix6d out = Matrix6d::Zero();
  out.topLeftCorner<3, 3>() = hat(a.tail<3>());
  out.bottomRightCorner<3, 3>() = hat(a.tail<3>());
  out.topRightCorner<3, 3>() = hat(a.head<3>());
  return out;
}

/// Moves a knot by (left perturbation of T_v0, change of varpi).
[[nodiscard]] inline TrajectoryKnot perturbed(const TrajectoryKnot& knot, const Vector12d& step) {
  return {knot.time, (SE3::exp(step.head<6>()) * knot.T_v0).normalized(), knot.varpi + step.tail<6>()};
}

}  // namespace mapless
