#include "detection/tracking/velocity_filter.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace mapless {
namespace MAPLESS_FILE {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Time seconds(double s) { return Time::from_seconds(s); }

TEST(VelocityFilter, VelocityGrowsUncertainWithTime) {
  VelocityFilter motion(seconds(1), {1, 2, 3}, 4 * Matrix3d::Identity(), 0.5);
  motion.predict(seconds(3));
  EXPECT_EQ(motion.velocity(), Vector3d(1, 2, 3));
  EXPECT_TRUE(motion.velocity_covariance().isApprox(5 * Matrix3d::Identity(), 1e-12));
  motion.predict(seconds(2));
  EXPECT_EQ(motion.time(), seconds(3)) << "never back";
}

// One displacement over 0.1 s and no prior velocity: the velocity is the displacement over the time. Its
// variance is that of the displacement over the time squared, plus q dt / 3 for the acceleration meanwhile.
TEST(VelocityFilter, OneDisplacementDeterminesTheVelocity) {
  const double q = 0.5, dt = 0.1, std_m = 0.02;
  VelocityFilter motion(seconds(0), Vector3d::Zero(), 1e8 * Matrix3d::Identity(), q);
  motion.remember(3);
  EXPECT_EQ(motion.remembered(), 1u);
  motion.predict(seconds(dt));
  motion.observe(0, {0.5, -0.2, 0}, std_m * std_m * Matrix3d::Identity());
  EXPECT_LT((motion.velocity() - Vector3d(5, -2, 0)).norm(), 1e-4);
  const double variance = std_m * std_m / (dt * dt) + q * dt / 3;
  EXPECT_NEAR(motion.velocity_covariance()(0, 0) / variance, 1, 1e-3);
}

// An unobserved direction keeps its uncertainty.
TEST(VelocityFilter, AnUnobservedDirectionStaysUnknown) {
  VelocityFilter motion(seconds(0), Vector3d::Zero(), 100 * Matrix3d::Identity(), 0.1);
  for (int k = 1; k <= 20; ++k) {
    motion.remember(3);
    motion.predict(seconds(0.1 * k));
    motion.observe(0, {0.3, 0, 0}, Vector3d(1e-4, 1e6, 1e-4).asDiagonal());
  }
  EXPECT_NEAR(motion.velocity().x(), 3, 0.01);
  EXPECT_GT(motion.velocity_covariance()(1, 1), 95);
  EXPECT_LT(motion.velocity_covariance()(0, 0), 0.1);
}

// One displacement over a long time determines the velocity better than many over short times.
TEST(VelocityFilter, RemembersEarlierScans) {
  const Matrix3d covariance = 1e-4 * Matrix3d::Identity();
  const auto run = [&covariance](bool far) {
    VelocityFilter motion(seconds(0), Vector3d::Zero(), 100 * Matrix3d::Identity(), 1e-6);
    for (int k = 1; k <= 5; ++k) {
      motion.remember(5);
      motion.predict(seconds(0.1 * k));
      motion.observe(0, {0.2, 0, 0}, covariance);
    }
    EXPECT_EQ(motion.remembered(), 5u);
    if (far) motion.observe(4, {1, 0, 0}, covariance);
    return motion;
  };
  EXPECT_NEAR(run(true).velocity().x(), 2, 1e-2);
  // Five displacements of variance r each over T = 0.5 s: 5 r / T^2; with one over all of it, 1 / (1 / 5 +
  // 1).
  EXPECT_NEAR(run(false).velocity_covariance()(0, 0), 5e-4 / 0.25, 1e-5);
  EXPECT_NEAR(run(true).velocity_covariance()(0, 0), 1e-4 / 1.2 / 0.25, 1e-5);
}

TEST(VelocityFilter, AnUnexpectedDisplacementMakesItUncertain) {
  const Matrix3d covariance = 1e-4 * Matrix3d::Identity();
  VelocityFilter motion(seconds(0), Vector3d::Zero(), 100 * Matrix3d::Identity(), 0.1);
  for (int k = 1; k <= 10; ++k) {
    motion.remember(3);
    motion.predict(seconds(0.1 * k));
    motion.observe(0, {0.3, 0, 0}, covariance);
  }
  const double before = motion.velocity_covariance()(0, 0);
  motion.remember(3);
  motion.predict(seconds(1.1));
  motion.observe(0, {-0.3, 0, 0}, covariance);
  EXPECT_GT(motion.velocity_covariance()(0, 0), 1.5 * before);
  for (int k = 12; k <= 15; ++k) {
    motion.remember(3);
    motion.predict(seconds(0.1 * k));
    motion.observe(0, {-0.3, 0, 0}, covariance);
  }
  EXPECT_NEAR(motion.velocity().x(), -3, 0.5) << "a ball that bounced is believed soon";
}

TEST(VelocityFilter, KeepsAPositiveVarianceOverAnHour) {
  VelocityFilter motion(seconds(0), Vector3d::Zero(), 100 * Matrix3d::Identity(), 0.25);
  for (int k = 1; k <= 36000; ++k) {
    motion.remember(5);
    motion.predict(seconds(0.1 * k));
    motion.observe(0, {0.5, 0.1, 0}, 4e-4 * Matrix3d::Identity());
    if (k > 5) motion.observe(4, {2.5, 0.5, 0}, 4e-4 * Matrix3d::Identity());
  }
  EXPECT_LT((motion.velocity() - Vector3d(5, 1, 0)).norm(), 1e-6);
  const Matrix3d P = motion.velocity_covariance();
  EXPECT_GT(P(0, 0), 0);
  EXPECT_LT(P(0, 0), 0.1);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
