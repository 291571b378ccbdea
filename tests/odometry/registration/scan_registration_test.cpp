#include "odometry/registration/scan_registration.hpp"

#include <algorithm>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "odometry/map/plane_map.hpp"

namespace mapless {
namespace MAPLESS_FILE {

constexpr double kScan = 0.1;  // [s]
constexpr AccelerationDensity kDensity = {0.3, 0.02};

// For a sensor at rest, pose and velocity propagate as on a line: the pose by velocity x time, with the
// covariance of white noise on acceleration added (Barfoot, State Estimation for Robotics, 11.1.4).
Matrix12d propagated(const Matrix12d& covariance) {
  Matrix12d F = Matrix12d::Identity(), Q = Matrix12d::Zero();
  F.topRightCorner<6, 6>().diagonal().setConstant(kScan);
  for (int i = 0; i < 6; ++i) {
    const double density = i < 3 ? kDensity.translation : kDensity.rotation;
    Q(i, i) = kScan * kScan * kScan / 3 * density;
    Q(i, 6 + i) = Q(6 + i, i) = kScan * kScan / 2 * density;
    Q(6 + i, 6 + i) = kScan * density;
  }
  return F * covariance * F.transpose() + Q;
}

// Scans without a point to register: the motion prior of each interval must enter exactly once, for any
// number of open knots.
TEST(ScanRegistration, ExtrapolatedWithThePriorTheCovarianceGrowsByTheMotionOfEveryScan) {
  const RegistrationSettings settings = {kDensity, {1, 2.5}, 0.02, 1e-4, 10};
  const PlaneMap map(0.02);
  Matrix12d covariance = 1e-4 * Matrix12d::Identity();
  const Matrix12d first = covariance.inverse();
  WindowPrior prior = prior_of({Time::from_seconds(0), SE3(), Vector6d::Zero()}, first);
  for (int k = 1; k <= 6; ++k) {
    std::vector<TrajectoryKnot> knots = prior.mean;
    knots.push_back({Time::from_seconds(kScan * k), SE3(), Vector6d::Zero()});
    const auto carried = register_scan(knots, prior, TimeBins({}, Time(), Time()), map, settings);
    ASSERT_TRUE(carried);
    covariance = propagated(covariance);
    EXPECT_LT((carried->last_information.inverse() - covariance).norm(), 1e-6 * covariance.norm()) << k;
    EXPECT_EQ(carried->posterior.mean.size(), std::min<std::size_t>(kWindowKnots, knots.size())) << k;
    prior = carried->posterior;
  }
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
