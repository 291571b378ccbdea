#include "odometry/solver/prior_terms.hpp"

#include <gtest/gtest.h>

#include "odometry/small_problem.hpp"

namespace mapless {
namespace MAPLESS_FILE {

TEST(PriorTerms, ConstantVelocityHasNoCost) {
  Vector6d varpi;
  varpi << -20, 1, 0.5, 0.3, -1, 3;
  const TrajectoryKnot k1 = {Time::from_seconds(1), SE3::exp(varpi), varpi};
  const TrajectoryKnot k2 = {Time::from_seconds(1.1), SE3::exp(0.1 * varpi) * k1.T_v0, varpi};
  EXPECT_LT(motion_error(k1, k2).norm(), 1e-9);
}

TEST(PriorTerms, MotionJacobianIsTheDerivative) {
  std::mt19937 generator(3);
  const auto knots = test::moving_knots(2, generator);
  const auto error = [](const TrajectoryKnot& k1, const TrajectoryKnot& k2) -> Eigen::VectorXd {
    return motion_error(k1, k2);
  };
  const Eigen::MatrixXd numerical = test::numerical_jacobian(knots[0], knots[1], error);
  EXPECT_LT((numerical - motion_jacobian(knots[0], knots[1])).cwiseAbs().maxCoeff(), 2e-5);
}

// Q = [dt^3/3 Qc, dt^2/2 Qc; dt^2/2 Qc, dt Qc] (method.md section 3).
TEST(PriorTerms, InformationIsTheInverseOfTheCovariance) {
  const double dt = 0.1;
  Vector6d density;
  density << 2, 2, 2, 0.3, 0.3, 0.3;
  const Matrix6d Qc = density.asDiagonal();
  Matrix12d Q;
  Q << dt * dt * dt / 3 * Qc, dt * dt / 2 * Qc, dt * dt / 2 * Qc, dt * Qc;
  EXPECT_LT((motion_information(dt, {2, 0.3}) * Q - Matrix12d::Identity()).norm(), 1e-9);
}

// Ends that are both faster by dv than the mean between them cost dv^2 / 2 over the variance T Qc / 12 that
// white noise has there (method.md section 6), with the smaller density; a change from one steady velocity to
// another, here by 2 dv over the interval, has the same cost for any density within.
TEST(PriorTerms, TheMotionWithinAnIntervalHasItsOwnDensity) {
  const double dt = 0.1, dv = 0.3;
  const AccelerationDensity free = {2, 0.5}, register_at_speed = {2, 0.5, 0.02, 0.01};
  for (int axis = 0; axis < 6; ++axis) {
    SCOPED_TRACE(axis);
    Vector12d bent = Vector12d::Zero(), change = Vector12d::Zero();
    bent[axis] = -dt * dv;  // xi = 0, both velocities dv
    change[axis] = dt * dv;
    change[axis + 6] = 2 * dv;
    const auto cost = [&](const Vector12d& e, const AccelerationDensity& density) {
      return 0.5 * e.dot(motion_information(dt, density) * e);
    };
    const double density = axis < 3 ? free.translation : free.rotation;
    const double within =
        axis < 3 ? register_at_speed.max_within_translation : register_at_speed.max_within_rotation;
    EXPECT_NEAR(cost(bent, free), 0.5 * dv * dv / (dt * density / 12), 1e-9);
    EXPECT_NEAR(cost(bent, register_at_speed), 0.5 * dv * dv / (dt * within / 12), 1e-9);
    EXPECT_NEAR(cost(change, register_at_speed), 0.5 * 4 * dv * dv / (dt * density), 1e-9);
    EXPECT_NEAR(cost(change, register_at_speed), cost(change, free), 1e-9);
  }
}

// An interval of 0.24 or 0.36 s has the information of two or three of 0.12 s, in each of which the motion is
// bounded: their covariances, carried to the end by T_v0, add up.
TEST(PriorTerms, ALongIntervalIsLikeSeveralShortOnes) {
  const AccelerationDensity density = {2, 0.5, 0.02, 0.01};
  const double h = 0.12;
  Matrix12d carry = Matrix12d::Identity();
  carry.topRightCorner<6, 6>() = h * Matrix6d::Identity();
  const Matrix12d of_short = motion_information(h, density).inverse();
  Matrix12d covariance = of_short;
  for (const int n : {2, 3}) {
    covariance = carry * covariance * carry.transpose() + of_short;
    EXPECT_LT((motion_information(n * h, density) * covariance - Matrix12d::Identity()).norm(), 1e-9) << n;
  }
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
