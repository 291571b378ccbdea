#include "odometry/solver/prior_terms.hpp"

#include <algorithm>

#include "odometry/solver/knot_interval.hpp"

namespace mapless::inline v1 {

Vector12d motion_error(const TrajectoryKnot& k1, const TrajectoryKnot& k2) {
  const KnotInterval interval(k1, k2);
  Vector12d e;
  e << interval.xi() - interval.dt() * k1.varpi, interval.velocity_2() - k1.varpi;
  return e;
}

Eigen::Matrix<double, 12, 24> motion_jacobian(const TrajectoryKnot& k1, const TrajectoryKnot& k2) {
  const KnotInterval interval(k1, k2);
  const Matrix6d& to_pose_1 = interval.xi_to_pose_1();
  const Matrix6d& to_pose_2 = interval.jacobian_inverse();
  Eigen::Matrix<double, 12, 24> J = Eigen::Matrix<double, 12, 24>::Zero();
  J.block<6, 6>(0, 0) = to_pose_1;
  J.block<6, 6>(0, 6) = -interval.dt() * Matrix6d::Identity();
  J.block<6, 6>(0, 12) = to_pose_2;
  J.block<6, 6>(6, 0) = interval.velocity_2_to_xi() * to_pose_1;
  J.block<6, 6>(6, 6) = -Matrix6d::Identity();
  J.block<6, 6>(6, 12) = interval.velocity_2_to_xi() * to_pose_2;
  J.block<6, 6>(6, 18) = interval.jacobian_inverse();
  return J;
}

// Q^-1 of one axis group is the sum of two parts (method.md section 6): that of the change of velocity,
// (0, 0; 0, 1/dt) / Qc, and that of the motion within the interval, (12/dt^3, -6/dt^2; -6/dt^2, 3/dt) / Qw.
Matrix12d motion_information(double dt, const AccelerationDensity& density) {
  const auto both = [](double translation, double rotation) {
    Vector6d out;
    out << Eigen::Vector3d::Constant(1 / translation), Eigen::Vector3d::Constant(1 / rotation);
    return Matrix6d(out.asDiagonal());
  };
  const Matrix6d change = both(density.translation, density.rotation);
  const Matrix6d within = both(std::min(density.translation, density.max_within_translation),
                               std::min(density.rotation, density.max_within_rotation));
  Matrix12d out;
  out.topLeftCorner<6, 6>() = 12 / (dt * dt * dt) * within;
  out.topRightCorner<6, 6>() = -6 / (dt * dt) * within;
  out.bottomLeftCorner<6, 6>() = out.topRightCorner<6, 6>();
  out.bottomRightCorner<6, 6>() = 3 / dt * within + 1 / dt * change;
  return out;
}

void add_motion_prior(const std::vector<TrajectoryKnot>& knots, std::size_t k,
                      const AccelerationDensity& density, WindowSystem& system) {
  const Vector12d e = motion_error(knots[k], knots[k + 1]);
  const Eigen::Matrix<double, 12, 24> J = motion_jacobian(knots[k], knots[k + 1]);
  const Matrix12d W = motion_information((knots[k + 1].time - knots[k].time).seconds(), density);
  const Eigen::Matrix<double, 24, 12> JtW = J.transpose() * W;
  system.add(k, JtW * J, JtW * e);
}

}  // namespace mapless
