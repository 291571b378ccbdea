#include <cmath>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "live/live_robot.hpp"
#include "live/measurement_queue.hpp"

namespace mapless {
namespace MAPLESS_FILE {

using testing::HasSubstr;

using test::at_ms;
using test::cloud;
using test::kScans;
using test::kTurnMs;
using test::Robot;
using test::street;
using test::with_own_odometry;

constexpr double kImuYaw = 0.5;

LiveOptions with_measurements() {
  LiveOptions options = with_own_odometry();
  options.live.use_imu = true;
  options.live.use_wheel_odometry = true;
  return options;
}

// The lidar and the inertial sensor, turned about z, have base_link in common; the lidar is 1 m ahead of it.
void place_sensors(Robot& robot) {
  robot.live().add_transform("base_link", "lidar", Time(), SE3(Eigen::Matrix3d::Identity(), {1, 0, 2}), true);
  robot.live().add_transform("base_link", "imu_link", Time(), SE3(rotation_z(kImuYaw), {-1, 0.5, 0}), true);
}

// Cloud k and what the sensors measure during it: the true motion, plus `error`.
void turn_measured(Robot& robot, int k, const Eigen::Vector3d& error, int clock_ms = 0) {
  for (int ms = kTurnMs * k; ms < kTurnMs * (k + 1); ms += 20) {
    const TrajectoryState truth = street().trajectory->at(at_ms(ms));
    // varpi is of the world in the sensor frame.
    const Eigen::Vector3d angular_v = -truth.varpi.tail<3>() + error;
    const Eigen::Vector3d linear_v = -truth.varpi.head<3>();
    const Time stamp = at_ms(1000 + ms + clock_ms);
    robot.live().add_angular_velocity("imu_link", stamp, rotation_z(-kImuYaw) * angular_v);
    robot.live().add_twist("base_link", stamp, linear_v - angular_v.cross(Eigen::Vector3d(1, 0, 2)),
                           angular_v);
  }
  robot.turn(cloud(k));
}

// The inertial sensor is turned by 90 degrees about z: its x is the lidar's y. The lidar, 1 m ahead of
// base_link, moves with (2, 0, 0) + (0, 0, 1) x (1, 0, 2) = (2, 1, 0) m/s.
TEST(LiveMeasurements, AreTakenInAxesAndAtTheOriginOfTheLidar) {
  TransformBuffer transforms;
  transforms.add("base_link", "lidar", Time(), SE3(Eigen::Matrix3d::Identity(), {1, 0, 2}), true);
  transforms.add("base_link", "imu_link", Time(), SE3(rotation_z(M_PI / 2), {-1, 0.5, 0}), true);
  const LiveOptions options = with_measurements();
  MeasurementQueue queue(options.live);
  Health health;
  queue.add({"imu_link", at_ms(1000), std::nullopt, {0.1, 0, 0.3}}, at_ms(1000), Time(), health);
  queue.add({"base_link", at_ms(1050), Eigen::Vector3d(2, 0, 0), {0, 0, 1}}, at_ms(1000), Time(), health);
  queue.add({"imu_link", at_ms(1110), std::nullopt, {1, 1, 1}}, at_ms(1000), Time(), health);
  const auto taken = queue.take("lidar", at_ms(1000), at_ms(1100), transforms, Time(), health);
  ASSERT_EQ(taken.size(), 2U);
  EXPECT_EQ(taken[0].quantity, MeasuredMotion::angular_velocity);
  EXPECT_LT((taken[0].value - Eigen::Vector3d(0, 0.1, 0.3)).norm(), 1e-12);
  EXPECT_EQ(taken[1].quantity, MeasuredMotion::speed);
  EXPECT_LT((taken[1].value - Eigen::Vector3d(std::sqrt(5), 0, 0)).norm(), 1e-12);
  EXPECT_EQ(health.level(Time()), LiveLevel::ok);
  EXPECT_EQ(queue.take("lidar", at_ms(1100), at_ms(1200), transforms, Time(), health).size(), 1U);
}

TEST(LiveMeasurements, TrueOnesAreUsedAndTheMotionIsGood) {
  Robot robot(with_measurements());
  place_sensors(robot);
  for (int k = 0; k < 14; ++k) turn_measured(robot, k, Eigen::Vector3d::Zero());
  EXPECT_EQ(robot.diagnostics().level, LiveLevel::ok) << robot.diagnostics().message;
  EXPECT_EQ(robot.value("motion"), "good");
  EXPECT_EQ(robot.value("measurements"), "140");  // 14 clouds, 5 instants, 2 sensors
  const auto odometry = live_odometry(robot.outputs().back());
  ASSERT_TRUE(odometry);
  const TrajectoryState truth = street().trajectory->at(at_ms(0) + (odometry->time - at_ms(1000)));
  EXPECT_LT((odometry->velocity_b + truth.varpi).head<3>().norm(), 0.3);
}

// Measurements 20 sigma off (sigma 0.05 rad/s) contradict every motion that the points admit.
TEST(LiveMeasurements, WrongOnesReachTheOdometry) {
  Robot robot(with_measurements());
  place_sensors(robot);
  for (int k = 0; k < 12; ++k) turn_measured(robot, k, Eigen::Vector3d::Zero());
  ASSERT_EQ(robot.value("motion"), "good");
  for (int k = 12; k < 16; ++k) turn_measured(robot, k, {1, 0, 0});
  EXPECT_EQ(robot.value("motion"), "lost");
}

// After five lost scans in a row (docs/odometry.md) a new map begins, at an unknown place in the world
// before.
TEST(LiveMeasurements, AfterALossTheWorldIsAnother) {
  Robot robot(with_measurements());
  place_sensors(robot);
  for (int k = 0; k < 12; ++k) turn_measured(robot, k, Eigen::Vector3d::Zero());
  for (int k = 12; k < 18; ++k) turn_measured(robot, k, {1, 0, 0});
  for (int k = 18; k < kScans; ++k) turn_measured(robot, k, Eigen::Vector3d::Zero());
  ASSERT_EQ(robot.value("motion"), "good");
  std::uint32_t world = 0;
  for (const LiveOutput& output : robot.outputs()) {
    const bool restarted = output.labelled.odometry->outcome == ScanOutcome::restarted;
    EXPECT_EQ(output.world_number, restarted ? ++world : world);
  }
  EXPECT_EQ(world, 1U);
}

TEST(LiveMeasurements, AnInputThatIsSilentIsReportedAndLabelsGoOn) {
  Robot robot(with_measurements());
  place_sensors(robot);
  robot.drive(0, 12);
  EXPECT_EQ(robot.outputs().size(), 11U);
  EXPECT_EQ(robot.diagnostics().level, LiveLevel::warning);
  EXPECT_THAT(robot.diagnostics().message, HasSubstr("imu: nothing was measured during the cloud"));
  EXPECT_THAT(robot.diagnostics().message, HasSubstr("wheel odometry: nothing was measured"));
}

TEST(LiveMeasurements, AnotherClockIsReportedAndNotUsed) {
  Robot robot(with_measurements());
  place_sensors(robot);
  robot.drive(0, 1);
  for (int k = 1; k < 12; ++k) turn_measured(robot, k, {1, 0, 0}, 5000);
  EXPECT_THAT(robot.diagnostics().message, HasSubstr("imu: its stamps are 5."));
  EXPECT_EQ(robot.value("measurements"), "0");
  EXPECT_EQ(robot.value("motion"), "good");
}

TEST(LiveMeasurements, AFrameWithoutPlaceIsReportedAndNotUsed) {
  Robot robot(with_measurements());
  robot.live().add_transform("base_link", "lidar", Time(), SE3(), true);
  for (int k = 0; k < 12; ++k) turn_measured(robot, k, Eigen::Vector3d::Zero());
  EXPECT_THAT(robot.diagnostics().message,
              HasSubstr("imu: no static transforms place frame imu_link on lidar, and it is not used"));
  EXPECT_EQ(robot.value("motion"), "good");
}

TEST(LiveMeasurements, ValuesThatAreNotFiniteAreReportedAndNotUsed) {
  Robot robot(with_measurements());
  place_sensors(robot);
  for (int k = 0; k < 12; ++k) turn_measured(robot, k, {std::nan(""), 0, 0});
  EXPECT_THAT(robot.diagnostics().message, HasSubstr("imu: a velocity that is not finite is not used"));
  EXPECT_EQ(robot.value("motion"), "good");
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
