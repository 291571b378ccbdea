#include "odometry/solver/prior_terms.hpp"

#include <algorithm>

#include "odometry/solver/knot_interval.hpp"

namespace mapless::inline v1 {
namespace {

// The bound of the density within an interval holds in full up to this duration: a scan at 10 Hz, with room
// for motors that turn slower. Derived for longer intervals: with n knots in place of one, at each of which
// the velocity changes freely, the part e_p / dt - e_v / 2 of the whole interval would have 1 - 1 / n^2 of
// the free density (n = 2: 3/4), and 1 / n^2 of the bounded one. Measured at 5 Hz, where a step of a person
// takes two scans: forests err by .6 to 1.3 cm a scan, not .9 to 2.4 (docs/notebook/odometry.md, "Five turns
// a second").
constexpr double kBoundedFor_s = 0.12;

}  // namespace

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
  const double bounded_part = std::min(1.0, kBoundedFor_s * kBoundedFor_s / (dt * dt));
  const auto bounded = [&](double value, double bound) {
    const double least = std::min(value, bound);
    return least + (1 - bounded_part) * (value - least);
  };
  const auto both = [](double translation, double rotation) {
    Vector6d out;
    out << Eigen::Vector3d::Constant(1 / translation), Eigen::Vector3d::Constant(1 / rotation);
    return Matrix6d(out.asDiagonal());
  };
  const Matrix6d change = both(density.translation, density.rotation);
  const Matrix6d within = both(bounded(density.translation, density.max_within_translation),
                               bounded(density.rotation, density.max_within_rotation));
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
