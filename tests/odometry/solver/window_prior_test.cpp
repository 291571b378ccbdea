#include "odometry/solver/window_prior.hpp"

#include <gtest/gtest.h>

#include "odometry/small_problem.hpp"

namespace mapless {
namespace MAPLESS_FILE {

constexpr AccelerationDensity kDensity = {10, 1};

TEST(WindowPrior, PullsAKnotToItsMean) {
  std::mt19937 generator(4);
  std::vector<TrajectoryKnot> knots = test::moving_knots(1, generator);
  const WindowPrior prior =
      prior_of(perturbed(knots[0], test::random_step(generator, 0.2, 1)), 3 * Matrix12d::Identity());
  for (int i = 0; i < 5; ++i) {
    WindowSystem system(1);
    add_window_prior(prior, knots, 0, system);
    knots[0] = perturbed(knots[0], solve(system).value().step[0]);
  }
  EXPECT_LT(knot_error(prior.mean[0], knots[0]).norm(), 1e-9);
}

/// A chain of knots, each measured once.
class Chain : public testing::TestWithParam<std::size_t> {
 protected:
  static constexpr int kSteps = 6;

  Chain() {
    std::mt19937 generator(11);
    truth_ = test::moving_knots(7, generator);
    for (const auto& knot : truth_) {
      measured_.push_back(
          prior_of(perturbed(knot, test::random_step(generator, 1e-3, 1e-2)), 1e3 * Matrix12d::Identity()));
    }
  }

  struct Solved {
    std::vector<TrajectoryKnot> knots;
    WindowPrior posterior;
  };
  // `knots` are consecutive from number `first` on; those from `newest` on have a measurement and a motion
  // prior.
  [[nodiscard]] Solved solved(std::vector<TrajectoryKnot> knots, const WindowPrior& prior, std::size_t first,
                              std::size_t newest, std::size_t kept) const {
    Solved out;
    for (int i = 0; i < kSteps; ++i) {
      WindowSystem system(knots.size());
      add_window_prior(prior, knots, 0, system);
      for (std::size_t k = newest - first; k < knots.size(); ++k) {
        add_window_prior(measured_[first + k], knots, k, system);
        add_motion_prior(knots, k - 1, kDensity, system);
      }
      const WindowSolution solution = solve(system).value();
      for (std::size_t k = 0; k < knots.size(); ++k) knots[k] = perturbed(knots[k], solution.step[k]);
      out.posterior = marginal_of_last(kept, knots, system, solution);
    }
    out.knots = std::move(knots);
    return out;
  }

  std::vector<TrajectoryKnot> truth_;
  std::vector<WindowPrior> measured_;
};

// A sliding window that marginalises all but the last few knots must give the same last knots as the full
// batch.
TEST_P(Chain, WindowsAgreeWithTheFullBatch) {
  const std::size_t kept = GetParam();
  const Solved batch = solved(truth_, measured_[0], 0, 1, 1);

  Solved window = {{}, measured_[0]};
  for (std::size_t k = 1; k < truth_.size(); ++k) {
    std::vector<TrajectoryKnot> knots = window.posterior.mean;
    knots.push_back(truth_[k]);
    window = solved(knots, window.posterior, k + 1 - knots.size(), k, kept);
  }
  ASSERT_EQ(window.knots.size(), kept + 1);
  // The bound is the curvature of the problem, which a linear prior does not contain.
  for (std::size_t back = 1; back <= kept + 1; ++back)
    EXPECT_LT(knot_error(batch.knots[7 - back], window.knots[kept + 1 - back]).norm(), 2e-5) << back;
  const Matrix12d& expected = batch.posterior.diagonal.back();
  const WindowPrior& posterior = window.posterior;
  EXPECT_EQ(posterior.mean.size(), kept);
  WindowSystem system(kept);
  add_window_prior(posterior, posterior.mean, 0, system);
  EXPECT_LT((solve(system).value().information.back() - expected).norm(), 1e-3 * expected.norm());
}
INSTANTIATE_TEST_SUITE_P(KnotsKept, Chain, testing::Values(1, 2, 3));

}  // namespace MAPLESS_FILE
}  // namespace mapless
