#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "support/toy_scene.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/odometry/lidar_odometry.hpp>

// What another sensor measures of the motion decides where the scans do not.
namespace mapless {
namespace MAPLESS_FILE {

using test::ToyScene;

constexpr double kSpeed_mps = 10;
constexpr int kScans = 8;

// A tunnel with a constant cross-section: its points do not constrain the motion along it.
ToyScene tunnel() {
  ToyScene out = test::toy_room("VLP-16", test::drive(kSpeed_mps, 0));
  out.world.clear();
  for (const double side : {-1.0, 1.0}) {
    out.world.push_back(test::toy_box({0, side * 4, 0}, {2000, 0.5, 4}));
    out.world.push_back(test::toy_box({0, 0, side * 3}, {2000, 5, 0.5}));
  }
  return out;
}

MotionMeasurement measured(MeasuredMotion quantity, const Eigen::Vector3d& value, double at_s = 0) {
  return {Time::from_seconds(at_s), quantity, value, std::nullopt};
}

// The way that the odometry finds after kScans scans of the tunnel [m].
double way_m(const std::vector<MotionMeasurement>& all) {
  LidarOdometry odometry;
  for (const MotionMeasurement& one : all) odometry.add_measurement(one);
  const ToyScene scene = tunnel();
  for (int k = 0; k < kScans; ++k) (void)odometry.process(cast_scan(scene, k).scan);
  return odometry.knots().back().T_v0.inverse().translation().norm();
}

TEST(MotionMeasurements, DecidesTheSpeedAlongATunnel) {
  const double way = kSpeed_mps * 0.1 * kScans;
  EXPECT_NEAR(way_m({measured(MeasuredMotion::velocity, {kSpeed_mps, 0, 0})}), way, 0.1 * way);
  std::vector<MotionMeasurement> speeds;
  for (int k = 0; k <= 4 * kScans; ++k)
    speeds.push_back(measured(MeasuredMotion::speed, {kSpeed_mps, 0, 0}, 0.025 * k));
  EXPECT_NEAR(way_m(speeds), way, 0.02 * way);
  EXPECT_GT(std::abs(way_m({}) - way), 0.2 * way) << "without measurements the way is not known";
}

TEST(MotionMeasurements, AMotionThatContradictsItIsLost) {
  const ToyScene street = test::toy_street("VLP-16");  // at 8 m/s
  LidarOdometry odometry;
  OdometryUpdate update;
  for (int k = 0; k < 14; ++k) {
    if (k == 12) odometry.add_measurement(measured(MeasuredMotion::speed, {20, 0, 0}, 1.25));
    update = odometry.process(cast_scan(street, k).scan);
    if (k == 11) {
      EXPECT_EQ(update.state, MotionState::good);
    }
    if (k == 12) {
      EXPECT_EQ(update.outcome, ScanOutcome::unsupported);
    }
  }
  EXPECT_EQ(update.state, MotionState::good) << "of the scan after it";
}

TEST(MotionMeasurements, RefusesWhatIsNoMeasurement) {
  LidarOdometry odometry;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(odometry.add_measurement(measured(MeasuredMotion::velocity, {0, nan, 0})), InputError);
  EXPECT_THROW(odometry.add_measurement(measured(MeasuredMotion::speed, {-1, 0, 0})), InputError);
  MotionMeasurement exact = measured(MeasuredMotion::speed, {1, 0, 0});
  exact.sigma = 0;
  EXPECT_THROW(odometry.add_measurement(exact), InputError);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
