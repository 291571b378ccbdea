#include <array>
#include <cmath>
#include <vector>

#include <ceres/ceres.h>
#include <gtest/gtest.h>

#include "odometry/registration/time_bins.hpp"
#include "odometry/small_problem.hpp"
#include "odometry/solver/window_prior.hpp"

// The same small window, solved by Ceres with numerical derivatives of the plain formulas, and by our solver.
namespace mapless {
namespace MAPLESS_FILE {

using Eigen::Vector3d;

constexpr AccelerationDensity kDensity = {10, 1};
constexpr PointWeights kWeights = {1e3, 1.4};  // no gate, which is not a smooth loss
constexpr std::size_t kKnots = 3;

struct Match {
  std::size_t interval;
  Time time;
  Vector3d p_v;
  MapPlane plane;
};

struct Problem {
  std::vector<TrajectoryKnot> guess;
  WindowPrior prior;
  std::vector<Match> matches;
};

Problem make_problem() {
  std::mt19937 generator(21);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::normal_distribution<double> normal;
  const auto truth = test::moving_knots(kKnots, generator);
  Problem out;
  for (int i = 0; i < 300; ++i) {
    const std::size_t k = i % (kKnots - 1);
    const Time t = truth[k].time + Duration::from_seconds(0.05 * (1 + uniform(generator)));
    const Vector3d p_v = 20 * Vector3d(uniform(generator), uniform(generator), uniform(generator));
    const Vector3d n = Vector3d(normal(generator), normal(generator), normal(generator)).normalized();
    const Vector3d p_0 = interpolate(truth[k], truth[k + 1], t).T_v0.inverse() * p_v;
    const double outlier = i % 10 == 0 ? 0.5 : 0.02;
    out.matches.push_back({k, t, p_v, {p_0 + outlier * normal(generator) * n, n, 0.02, 0}});
  }
  out.prior = prior_of(truth[0], 1e4 * Matrix12d::Identity());
  for (const auto& knot : truth)
    out.guess.push_back(perturbed(knot, test::random_step(generator, 0.01, 0.1)));
  return out;
}

TrajectoryKnot moved(const TrajectoryKnot& knot, const double* step) {
  return perturbed(knot, Eigen::Map<const Vector12d>(step));
}

struct MotionCost {
  TrajectoryKnot k1, k2;
  bool operator()(const double* a, const double* b, double* out) const {
    const Matrix12d W = motion_information((k2.time - k1.time).seconds(), kDensity);
    const Matrix12d root = W.llt().matrixU();
    Eigen::Map<Vector12d>{out} = root * motion_error(moved(k1, a), moved(k2, b));
    return true;
  }
};

struct PriorCost {
  WindowPrior prior;
  TrajectoryKnot knot;
  bool operator()(const double* a, double* out) const {
    const Matrix12d root = prior.diagonal[0].llt().matrixU();
    Eigen::Map<Vector12d>{out} = root * knot_error(prior.mean[0], moved(knot, a));
    return true;
  }
};

struct PointCost {
  Match match;
  TrajectoryKnot k1, k2;
  bool operator()(const double* a, const double* b, double* out) const {
    const SE3 T_v0 = interpolate(moved(k1, a), moved(k2, b), match.time).T_v0;
    const Vector3d p_0 = T_v0.inverse() * match.p_v;
    out[0] = match.plane.normal_0.dot(p_0 - match.plane.point_0) / std::sqrt(match.plane.variance);
    return true;
  }
};

std::vector<TrajectoryKnot> solve_with_ceres(const Problem& p) {
  std::array<Vector12d, kKnots> steps;
  steps.fill(Vector12d::Zero());
  ceres::Problem problem;
  problem.AddResidualBlock(new ceres::NumericDiffCostFunction<PriorCost, ceres::CENTRAL, 12, 12>(
                               new PriorCost{p.prior, p.guess[0]}),
                           nullptr, steps[0].data());
  for (std::size_t k = 0; k + 1 < kKnots; ++k) {
    problem.AddResidualBlock(new ceres::NumericDiffCostFunction<MotionCost, ceres::CENTRAL, 12, 12, 12>(
                                 new MotionCost{p.guess[k], p.guess[k + 1]}),
                             nullptr, steps[k].data(), steps[k + 1].data());
  }
  for (const Match& match : p.matches) {
    const std::size_t k = match.interval;
    problem.AddResidualBlock(new ceres::NumericDiffCostFunction<PointCost, ceres::CENTRAL, 1, 12, 12>(
                                 new PointCost{match, p.guess[k], p.guess[k + 1]}),
                             new ceres::CauchyLoss(kWeights.robust_sigmas), steps[k].data(),
                             steps[k + 1].data());
  }
  ceres::Solver::Options options;
  options.max_num_iterations = 200;
  options.function_tolerance = options.parameter_tolerance = options.gradient_tolerance = 1e-14;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  std::vector<TrajectoryKnot> out;
  for (std::size_t k = 0; k < kKnots; ++k) out.push_back(perturbed(p.guess[k], steps[k]));
  return out;
}

std::vector<TrajectoryKnot> solve_with_ours(const Problem& p) {
  auto knots = p.guess;
  for (int iteration = 0; iteration < 50; ++iteration) {
    WindowSystem system(kKnots);
    add_window_prior(p.prior, knots, 0, system);
    for (std::size_t k = 0; k + 1 < kKnots; ++k) add_motion_prior(knots, k, kDensity, system);
    for (const Match& match : p.matches) {
      const std::size_t k = match.interval;
      const auto at = KnotInterval(knots[k], knots[k + 1]).at(match.time);
      BinSums sums;
      sums.pose_jacobian = at.pose_jacobian;
      sums.add(point_residual(match.p_v, at.state.T_v0, match.plane, kWeights));
      add_points({sums}, k, 1, system);
    }
    const auto solution = solve(system).value();
    for (std::size_t k = 0; k < kKnots; ++k) knots[k] = perturbed(knots[k], solution.step[k]);
  }
  return knots;
}

TEST(CeresOracle, FindsTheSameKnots) {
  const Problem problem = make_problem();
  const auto expected = solve_with_ceres(problem);
  const auto found = solve_with_ours(problem);
  for (std::size_t k = 0; k < kKnots; ++k) {
    EXPECT_GT(knot_error(problem.guess[k], expected[k]).norm(), 1e-3) << "nothing to find";
    const Vector12d difference = knot_error(expected[k], found[k]);
    EXPECT_LT(difference.head<6>().norm(), 1e-5) << "pose of knot " << k;
    EXPECT_LT(difference.tail<6>().norm(), 1e-4) << "velocity of knot " << k;
  }
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
