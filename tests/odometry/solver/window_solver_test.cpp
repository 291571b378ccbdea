#include "odometry/solver/window_solver.hpp"

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
  // The covariance of the last knot is its block of the inverse of the whole matrix.
  const Matrix12d covariance = H.inverse().bottomRightCorner<12, 12>();
  EXPECT_LT((solution->information.back() * covariance - Matrix12d::Identity()).norm(), 1e-6);
}

TEST(WindowSolver, HasNoSolutionOfASingularSystem) {
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

}  // namespace MAPLESS_FILE
}  // namespace mapless
