#include "odometry/solver/motion_density.hpp"

#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace mapless {
namespace MAPLESS_FILE {

using Knots = std::vector<TrajectoryKnot>;

constexpr double kDt = 0.1;
constexpr AccelerationDensity kExpected = {0.03, 0.01};

// Knots with these mean velocities between them.
Knots knots_of(const std::vector<Vector6d>& means) {
  Knots knots = {{Time(), SE3(), Vector6d::Zero()}};
  for (const Vector6d& mean : means) {
    const SE3 T_v0 = SE3::exp(kDt * mean) * knots.back().T_v0;
    knots.push_back({knots.back().time + Duration::from_seconds(kDt), T_v0, mean});
  }
  return knots;
}

TEST(MotionDensity, IsTheExpectedOneBeforeTheFirstMotion) {
  const Knots knots = knots_of({Vector6d::Constant(3)});
  for (std::size_t n = 0; n <= knots.size(); ++n) {
    SCOPED_TRACE(n);
    const AccelerationDensity density = estimate_density(std::span(knots).first(n), kExpected);
    EXPECT_DOUBLE_EQ(density.translation, kExpected.translation);
    EXPECT_DOUBLE_EQ(density.rotation, kExpected.rotation);
  }
}

TEST(MotionDensity, OfASteadyMotionIsTheWeightOfTheExpectedOne) {
  const Knots knots = knots_of(std::vector<Vector6d>(60, Vector6d::LinSpaced(1, 6)));
  const AccelerationDensity density = estimate_density(knots, kExpected);
  // 21 knots have 20 intervals and 19 changes between them; the expected one has the weight of two.
  EXPECT_NEAR(density.translation, kExpected.translation * 2 / 21, 1e-9);
  EXPECT_NEAR(density.rotation, kExpected.rotation * 2 / 21, 1e-9);
}

// An angular acceleration a: the error of the prior, (a dt^2 / 2, a dt), has e^T Q^-1 e = a^2 dt / Qc on its
// axis, which is to be two. Over three axes that is a third as much each.
TEST(MotionDensity, OfAConstantAngularAccelerationMatchesThePriorsError) {
  constexpr double kAcceleration = 2;  // [rad/s^2]
  std::vector<Vector6d> means;
  for (int k = 0; k < 60; ++k) means.push_back(kAcceleration * kDt * k * Vector6d::Unit(5));
  const double expected = kAcceleration * kAcceleration * kDt / 2 / 3;
  EXPECT_NEAR(estimate_density(knots_of(means), {0, expected}).rotation, expected, 1e-6);
}

// Velocities under white noise on acceleration, averaged over their intervals from many small steps.
TEST(MotionDensity, OfWhiteNoiseOnAccelerationIsItsDensity) {
  constexpr double kDensity = 0.5;
  constexpr int kSteps = 200;
  double sum = 0;
  constexpr int kRuns = 100;
  for (unsigned seed = 0; seed < kRuns; ++seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> noise(0, std::sqrt(kDensity * kDt / kSteps));
    Vector6d velocity = Vector6d::Zero();
    std::vector<Vector6d> means;
    for (int k = 0; k < 22; ++k) {
      Vector6d mean = Vector6d::Zero();
      for (int step = 0; step < kSteps; ++step) {
        for (int axis = 0; axis < 3; ++axis) velocity[axis] += noise(random);
        mean += velocity / kSteps;
      }
      means.push_back(mean);
    }
    sum += estimate_density(knots_of(means), {kDensity, 0}).translation;
  }
  // 19 changes on three axes, neighbours correlated: 5 % are four standard deviations of the mean.
  EXPECT_NEAR(sum / kRuns, kDensity, 0.05 * kDensity);
}

TEST(MotionDensity, ForgetsAManoeuvre) {
  std::vector<Vector6d> means(60, Vector6d::Zero());
  for (std::size_t k = 10; k < 20; ++k) means[k] = Vector6d::Constant(static_cast<double>(k % 2));
  const Knots knots = knots_of(means);
  EXPECT_GT(estimate_density(std::span(knots).first(22), kExpected).translation, 10 * kExpected.translation);
  EXPECT_LT(estimate_density(knots, kExpected).translation, kExpected.translation);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
