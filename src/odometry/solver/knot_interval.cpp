#include "odometry/solver/knot_interval.hpp"

namespace mapless::inline v1 {

KnotInterval::KnotInterval(const TrajectoryKnot& k1, const TrajectoryKnot& k2)
    : k1_(k1), k2_(k2), dt_((k2.time - k1.time).seconds()) {
  const SE3 T_21 = k2.T_v0 * k1.T_v0.inverse();
  xi_ = T_21.log();
  jacobian_inverse_ = left_jacobian_inverse(xi_);
  velocity_2_ = jacobian_inverse_ * k2.varpi;
  xi_to_pose_1_ = -jacobian_inverse_ * adjoint(T_21);
  const Matrix6d xi_hat = curly_hat(xi_);
  const Matrix6d varpi_hat = curly_hat(k2.varpi);
  velocity_2_to_xi_ = 0.5 * varpi_hat - (curly_hat(xi_hat * k2.varpi) + xi_hat * varpi_hat) / 12;
}

KnotInterval::State KnotInterval::at(Time t) const {
  const double r = (t - k1_.time).seconds() / dt_;
  const double r2 = r * r;
  const double r3 = r2 * r;
  const double w1 = dt_ * (r - 2 * r2 + r3);
  const double w2 = 3 * r2 - 2 * r3;
  const double w3 = dt_ * (r3 - r2);
  const Vector6d gamma = w1 * k1_.varpi + w2 * xi_ + w3 * velocity_2_;
  const Vector6d gamma_dot =
      (1 - 4 * r + 3 * r2) * k1_.varpi + 6 * (r - r2) / dt_ * xi_ + (3 * r2 - 2 * r) * velocity_2_;
  const SE3 T_t1 = SE3::exp(gamma);
  const Matrix6d J = left_jacobian(gamma);
  const Matrix6d to_xi = J * (w2 * Matrix6d::Identity() + w3 * velocity_2_to_xi_);
  State out;
  out.state = {T_t1 * k1_.T_v0, J * gamma_dot};
  out.pose_jacobian.block<6, 6>(0, 0) = adjoint(T_t1) + to_xi * xi_to_pose_1_;
  out.pose_jacobian.block<6, 6>(0, 6) = w1 * J;
  out.pose_jacobian.block<6, 6>(0, 12) = to_xi * jacobian_inverse_;
  out.pose_jacobian.block<6, 6>(0, 18) = w3 * J * jacobian_inverse_;
  return out;
}

}  // namespace mapless
