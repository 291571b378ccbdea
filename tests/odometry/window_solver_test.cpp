#include "odometry/window_solver.hpp"

#include <limits>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "odometry/small_problem.hpp"

namespace mapless {
namespace MAPLESS_FILE {

constexpr int kKnots = 5;

WindowSystem random_system(unsigned seed) {
  std::srand(seed);
  WindowSystem system(kKnots);
  for (std::size_t k = 0; k + 1 < kKnots; ++k) {
    const Eigen::Matrix<double, 24, 24> A = Eigen::Matrix<double, 24, 24>::Random();
    system.add(k, A * A.transpose(), Eigen::Matrix<double, 24, 1>::Random());
  }
  return system;
}

Eigen::MatrixXd dense(const WindowSystem& system) {
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(12 * kKnots, 12 * kKnots);
  for (int k = 0; k < kKnots; ++k) {
    const auto i = static_cast<std::size_t>(k);
    H.block<12, 12>(12 * k, 12 * k) = system.diagonal[i];
    if (k + 1 == kKnots) break;
    H.block<12, 12>(12 * k, 12 * k + 12) = system.above[i];
    H.block<12, 12>(12 * k + 12, 12 * k) = system.above[i].transpose();
  }
  return H;
}

TEST(WindowSolver, AgreesWithTheDenseSolution) {
  const WindowSystem system = random_system(7);
  Eigen::VectorXd g(12 * kKnots);
  for (int k = 0; k < kKnots; ++k) g.segment<12>(12 * k) = system.gradient[static_cast<std::size_t>(k)];
  const Eigen::MatrixXd H = dense(system);
  const Eigen::VectorXd expected = H.fullPivLu().solve(-g);
  const auto solution = solve(system);
  ASSERT_TRUE(solution);
  for (int k = 0; k < kKnots; ++k) {
    EXPECT_LT((solution->step[static_cast<std::size_t>(k)] - expected.segment<12>(12 * k)).norm(),
              1e-7 * expected.norm());
  }
  // The covariance of the last knot is its block of the inverse of everything.
  const Matrix12d covariance = H.inverse().bottomRightCorner<12, 12>();
  EXPECT_LT((solution->last_information * covariance - Matrix12d::Identity()).norm(), 1e-6);
}

TEST(WindowSolver, HasNoAnswerWithoutOne) {
  WindowSystem system = random_system(8);
  system.diagonal[2].setZero();
  EXPECT_FALSE(solve(system));
  system = random_system(9);
  system.gradient[1][3] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(solve(system));
  system = random_system(9);
  system.diagonal[4](2, 2) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(solve(system));
}

constexpr AccelerationDensity kDensity = {10, 1};

std::vector<TrajectoryKnot> step_all(std::vector<TrajectoryKnot> knots, const WindowSolution& solution) {
  for (std::size_t k = 0; k < knots.size(); ++k) knots[k] = perturbed(knots[k], solution.step[k]);
  return knots;
}

// A chain of knots, each measured once. One window after the other, the older knot marginalised, must end
// where everything solved together ends.
TEST(WindowSolver, MarginalisingAgreesWithTheFullBatch) {
  std::mt19937 generator(11);
  const auto truth = test::moving_knots(6, generator);
  std::vector<KnotPrior> measured;
  for (const auto& knot : truth)
    measured.push_back(
        {perturbed(knot, test::random_step(generator, 1e-3, 1e-2)), 1e3 * Matrix12d::Identity()});

  auto batch = truth;
  WindowSolution batch_solution;
  for (int i = 0; i < 6; ++i) {
    WindowSystem system(batch.size());
    for (std::size_t k = 0; k < batch.size(); ++k) add_knot_prior(measured[k], batch, k, system);
    for (std::size_t k = 0; k + 1 < batch.size(); ++k) add_motion_prior(batch, k, kDensity, system);
    batch_solution = solve(system).value();
    batch = step_all(batch, batch_solution);
  }

  KnotPrior prior = measured[0];
  for (std::size_t k = 1; k < truth.size(); ++k) {
    std::vector<TrajectoryKnot> window = {prior.mean, truth[k]};
    for (int i = 0; i < 6; ++i) {
      WindowSystem system(2);
      add_knot_prior(prior, window, 0, system);
      add_knot_prior(measured[k], window, 1, system);
      add_motion_prior(window, 0, kDensity, system);
      const WindowSolution solution = solve(system).value();
      window = step_all(window, solution);
      prior.information = i == 5 ? solution.last_information : prior.information;
    }
    prior.mean = window[1];
  }
  // Less than the curvature of the problem, which a linear prior does not hold.
  EXPECT_LT(knot_error(batch.back(), prior.mean).norm(), 1e-5);
  EXPECT_LT((prior.information - batch_solution.last_information).norm(),
            1e-3 * batch_solution.last_information.norm());
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
