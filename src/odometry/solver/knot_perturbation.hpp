#pragma once

#include <mapless/core/se3.hpp>
#include <mapless/odometry/odometry_update.hpp>

namespace mapless::inline v1 {

// solver/ is the estimator's algebra. Knots, priors and normal equations go in; a Gauss-Newton step,
// marginals and the motion prior's terms come out. It knows neither scans nor the map. Every 12-vector is
// (left perturbation of T_v0, change of varpi), every 6-vector (translation, rotation) (method.md section 3).

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

/// Applies a 12-vector to a knot: exp(step_pose^) T_v0, varpi + step_varpi.
[[nodiscard]] inline TrajectoryKnot perturbed(const TrajectoryKnot& knot, const Vector12d& step) {
  return {knot.time, (SE3::exp(step.head<6>()) * knot.T_v0).normalized(), knot.varpi + step.tail<6>()};
}

}  // namespace mapless
