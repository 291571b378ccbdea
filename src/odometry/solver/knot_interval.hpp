#pragma once

#include "odometry/solver/knot_perturbation.hpp"

namespace mapless::inline v1 {

using Matrix6x24d = Eigen::Matrix<double, 6, 24>;

/// The posterior mean between two knots (Anderson and Barfoot, IROS 2015; method.md section 3), with its
/// derivatives with respect to the perturbations of both ends, in the order pose 1, varpi 1, pose 2, varpi 2.
/// The derivative of J^-1(xi) varpi_2 with respect to xi is that of the series of J^-1 up to third order; its
/// error is |rotation of xi|^3 / 180.
class KnotInterval {
 public:
  KnotInterval(const TrajectoryKnot& k1, const TrajectoryKnot& k2);

  struct State {
    TrajectoryState state;
    Matrix6x24d pose_jacobian;  ///< of the left perturbation of T_v0(t)
  };
  /// The same state as interpolate(). `t` may lie slightly outside the interval: a laser may fire before its
  /// column.
  [[nodiscard]] State at(Time t) const;

  [[nodiscard]] double dt() const { return dt_; }  ///< [s]
  /// xi = ln(T_2 T_1^-1), and J^-1(xi) varpi_2.
  [[nodiscard]] const Vector6d& xi() const { return xi_; }
  [[nodiscard]] const Vector6d& velocity_2() const { return velocity_2_; }
  [[nodiscard]] const Matrix6d& jacobian_inverse() const { return jacobian_inverse_; }
  [[nodiscard]] const Matrix6d& xi_to_pose_1() const { return xi_to_pose_1_; }
  [[nodiscard]] const Matrix6d& velocity_2_to_xi() const { return velocity_2_to_xi_; }

 private:
  TrajectoryKnot k1_, k2_;
  double dt_;
  Vector6d xi_;
  Matrix6d jacobian_inverse_;
  Vector6d velocity_2_;
  Matrix6d xi_to_pose_1_;
  Matrix6d velocity_2_to_xi_;
};

}  // namespace mapless
