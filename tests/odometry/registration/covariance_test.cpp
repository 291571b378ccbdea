#include <cmath>
#include <memory>
#include <random>
#include <vector>

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

#include "support/toy_scene.hpp"
#include <mapless/odometry/lidar_odometry.hpp>

namespace mapless {
namespace MAPLESS_FILE {

// A motion whose acceleration is white noise, as the motion prior assumes.
std::shared_ptr<const Trajectory> random_walk(unsigned seed, double seconds) {
  constexpr double kStep = 0.005;
  constexpr double kDensity[2] = {0.02, 0.004};  // [m^2/s^3], [rad^2/s^3]
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  Vector6d varpi = Vector6d::Zero();
  varpi[0] = -3;
  SE3 T_v0;
  std::vector<TimedPose> poses;
  for (double t = -0.1; t < seconds; t += kStep) {
    poses.push_back({Time::from_seconds(t), T_v0.inverse()});
    T_v0 = (SE3::exp(kStep * varpi) * T_v0).normalized();
    for (int i = 0; i < 6; ++i) varpi[i] += std::sqrt(kDensity[i / 3] * kStep) * normal(random);
  }
  return std::make_shared<SampledTrajectory>(poses, Duration(), "walk");
}

/// Normalised squared error of a vector per degree of freedom (NEES): 1 on average if the covariance is
/// right.
double normalised(const Eigen::VectorXd& error, const Eigen::MatrixXd& covariance) {
  return error.dot(covariance.ldlt().solve(error)) / static_cast<double>(error.size());
}

TEST(OdometryCovariance, MatchesTheErrorOfTheVelocity) {
  constexpr int kScans = 36, kSettled = 8;
  double linear = 0, angular = 0;
  int count = 0;
  for (const unsigned seed : {1U, 2U}) {
    test::ToyScene street = test::toy_street("VLP-16");
    street.trajectory = random_walk(seed, 0.1 * (kScans + 2));
    street.range_noise_m = 0.02;
    LidarOdometry odometry;
    for (int k = 0; k < kScans; ++k) {
      const OdometryUpdate update = odometry.process(cast_scan(street, k).scan);
      if (k < kSettled) continue;
      const TrajectoryKnot& knot = update.knots.back();
      const Vector6d error = knot.varpi - street.trajectory->at(knot.time).varpi;
      linear += normalised(error.head<3>(), update.covariance.block<3, 3>(6, 6));
      angular += normalised(error.tail<3>(), update.covariance.block<3, 3>(9, 9));
      ++count;
    }
  }
  EXPECT_GT(linear / count, 0.3);
  EXPECT_LT(linear / count, 4);
  EXPECT_GT(angular / count, 0.3);
  EXPECT_LT(angular / count, 4);
}

// The velocity at the end of a scan shows in the next scans: the first estimate errs by the density of the
// motion, the estimate two scans later hardly.
TEST(OdometryCovariance, LaterScansReduceTheErrorOfTheVelocity) {
  constexpr int kScans = 30, kSettled = 8;
  test::ToyScene street = test::toy_street("VLP-16");
  street.trajectory = random_walk(3, 0.1 * (kScans + 2));
  street.range_noise_m = 0.02;
  const auto squared_error = [&](const TrajectoryKnot& knot) {
    return (knot.varpi - street.trajectory->at(knot.time).varpi).head<3>().squaredNorm();
  };
  LidarOdometry odometry;
  double at_once = 0, later = 0;
  for (int k = 0; k < kScans; ++k) {
    const OdometryUpdate update = odometry.process(cast_scan(street, k).scan);
    if (k < kSettled) continue;
    ASSERT_EQ(update.knots.size(), 4U);
    at_once += squared_error(update.knots.back());
    later += squared_error(update.knots[1]);
  }
  EXPECT_LT(later, 0.25 * at_once);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
