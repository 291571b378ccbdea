#include "odometry/solver/knot_interval.hpp"

#include <gtest/gtest.h>

#include "odometry/small_problem.hpp"

namespace mapless {
namespace MAPLESS_FILE {

Time part(const TrajectoryKnot& k1, const TrajectoryKnot& k2, double r) {
  return k1.time + (k2.time - k1.time) * r;
}

TEST(KnotInterval, IsTheInterpolationOfTheTrajectory) {
  std::mt19937 generator(1);
  const auto knots = test::moving_knots(2, generator);
  const KnotInterval interval(knots[0], knots[1]);
  for (const double r : {0.0, 0.2, 0.5, 0.9, 1.0}) {
    const Time t = part(knots[0], knots[1], r);
    const TrajectoryState expected = interpolate(knots[0], knots[1], t);
    const TrajectoryState state = interval.at(t).state;
    EXPECT_LT((state.T_v0.matrix() - expected.T_v0.matrix()).norm(), 1e-12);
    EXPECT_LT((state.varpi - expected.varpi).norm(), 1e-10);
  }
}

TEST(KnotInterval, PoseJacobianIsTheDerivative) {
  std::mt19937 generator(2);
  const auto knots = test::moving_knots(2, generator);
  for (const double r : {0.0, 0.1, 0.5, 0.8, 1.0}) {
    SCOPED_TRACE(r);
    const Time t = part(knots[0], knots[1], r);
    const SE3 T_t0 = interpolate(knots[0], knots[1], t).T_v0;
    const auto perturbation = [&](const TrajectoryKnot& k1, const TrajectoryKnot& k2) -> Eigen::VectorXd {
      return (interpolate(k1, k2, t).T_v0 * T_t0.inverse()).log();
    };
    const Eigen::MatrixXd numerical = test::numerical_jacobian(knots[0], knots[1], perturbation);
    const Matrix6x24d analytic = KnotInterval(knots[0], knots[1]).at(t).pose_jacobian;
    EXPECT_LT((numerical - analytic).cwiseAbs().maxCoeff(), 2e-6);
  }
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
