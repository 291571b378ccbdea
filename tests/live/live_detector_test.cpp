#include <atomic>
#include <cmath>
#include <cstring>
#include <string>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "live/live_robot.hpp"
#include <mapless/lidar/scan_builder.hpp>

namespace mapless {
namespace MAPLESS_FILE {

using testing::AllOf;
using testing::HasSubstr;

using test::add_poses;
using test::at_ms;
using test::cloud;
using test::cloud_of;
using test::driving;
using test::kCloudsToRecover;
using test::kScans;
using test::kStep;
using test::kTurnMs;
using test::Robot;
using test::scans;
using test::street;
using test::with_own_odometry;
using test::with_poses;

TEST(LiveDetector, LabelsAreThoseOfTheOnlineDetector) {
  Robot robot(with_own_odometry());
  robot.drive(0, 16);
  ScanBuilder builder(*street().model);
  builder.set_turn_duration(Duration::from_seconds(0.1));
  OnlineDetector online;
  std::vector<LabelledScan> expected;
  for (int k = 0; k < 16; ++k) {
    const PointCloud2 one = cloud(k);
    for (LabelledScan& found :
         online.push(builder.build(read_point_cloud2(one.view, "").fields, one.view.stamp)))
      expected.push_back(std::move(found));
  }
  ASSERT_EQ(robot.outputs().size(), 15U);
  ASSERT_EQ(expected.size(), 15U);
  std::size_t moving = 0;
  for (std::size_t k = 0; k < expected.size(); ++k) {
    EXPECT_EQ(robot.outputs()[k].labelled.object_by_input(), expected[k].object_by_input());
    moving += expected[k].detection.tracked.size();
  }
  EXPECT_GT(moving, 10U);
  EXPECT_EQ(robot.diagnostics().level, LiveLevel::ok) << robot.diagnostics().message;
  EXPECT_EQ(robot.value("dropped"), "0");
  EXPECT_EQ(robot.value("input_rate_hz"), "10.00");
}

TEST(LiveDetector, LabelledCloudsHaveEveryFieldAndTheLabels) {
  const auto robot = driving(12);
  const LiveOutput& output = robot->outputs().back();
  const PointCloud2View& in = output.cloud.view;
  const PointCloud2 labelled = labelled_cloud(output);
  const PointCloud2View& out = labelled.view;
  EXPECT_EQ(out.stamp, in.stamp);
  EXPECT_EQ(out.frame_id, "lidar");
  ASSERT_EQ(out.size(), in.size());
  ASSERT_EQ(out.fields.size(), 9U);
  EXPECT_EQ(out.fields[6], (PointCloud2Field{"object_id", 24, 6, 1}));
  EXPECT_EQ(out.fields[7], (PointCloud2Field{"moving", 28, 2, 1}));
  EXPECT_EQ(out.fields[8], (PointCloud2Field{"probability", 32, 7, 1}));
  const std::vector<PointMotion> motions = point_motions(output);
  std::size_t moving = 0;
  for (std::size_t i = 0; i < out.size(); ++i) {
    const std::uint8_t* point = out.data.data() + i * out.point_step;
    ASSERT_EQ(std::memcmp(point, in.data.data() + i * in.point_step, kStep), 0);
    std::uint32_t id = 0;
    std::memcpy(&id, point + 24, 4);
    ASSERT_EQ(point[28], static_cast<std::uint8_t>(motions[i]));
    ASSERT_EQ(id != 0, motions[i] == PointMotion::moving);
    float probability = 0;
    std::memcpy(&probability, point + 32, 4);
    ASSERT_EQ(std::isnan(probability), motions[i] == PointMotion::unknown);
    moving += id != 0;
  }
  EXPECT_GT(moving, 0U);
  EXPECT_EQ(selected_cloud(output, PointMotion::moving).view.size(), moving);
  EXPECT_EQ(selected_cloud(output, PointMotion::still).view.size(), in.size() - moving);
  EXPECT_FALSE(live_objects(output).empty());
}

// As that of another mapless: its labels give way to the new ones, and its bytes stay.
TEST(LiveDetector, LabelsOfBeforeAreNotTakenForTheNew) {
  const auto robot = driving(12);
  LiveOutput output = robot->outputs().back();
  output.cloud.view.fields[3].name = "moving";
  output.cloud.view.fields[4].name = "object_id";
  const PointCloud2 labelled = labelled_cloud(output);
  std::vector<std::string> names;
  for (const PointCloud2Field& field : labelled.view.fields) names.push_back(field.name);
  EXPECT_THAT(names, testing::ElementsAre("x", "y", "z", "time", "object_id", "moving", "probability"));
  EXPECT_EQ(labelled.view.fields[5].offset, 28U);
  EXPECT_EQ(std::memcmp(labelled.view.data.data(), output.cloud.view.data.data(), kStep), 0);
}

// The lidar drives at 8 m/s along x; its world is that of the transforms, 2 m above base_link.
TEST(LiveDetector, GivenPosesPlaceObjectsInTheirWorld) {
  const auto robot = driving(12);
  const LiveOutput& output = robot->outputs().back();
  const Eigen::Vector3d sensor = output.labelled.T_0v().translation();
  const Time start = output.labelled.scan().start;
  const SE3 expected = street().trajectory->at(at_ms(0) + (start - at_ms(1000))).T_v0.inverse();
  EXPECT_LT((sensor - expected.translation()).norm(), 0.01);
  EXPECT_FALSE(live_odometry(output));
}

TEST(LiveDetector, OwnOdometryHasPoseAndVelocity) {
  Robot robot(with_own_odometry());
  robot.drive(0, 16);
  const auto odometry = live_odometry(robot.outputs().back());
  ASSERT_TRUE(odometry);
  const double time_s = (odometry->time - at_ms(1000)).seconds();
  const TrajectoryState truth = street().trajectory->at(Time::from_seconds(time_s));
  const SE3 T_v0_start = street().trajectory->at(Time()).T_v0;
  EXPECT_LT((odometry->T_wb.translation() - (T_v0_start * truth.T_v0.inverse()).translation()).norm(), 0.3);
  EXPECT_LT((odometry->velocity_b + truth.varpi).head<3>().norm(), 0.3);
  EXPECT_GT(odometry->velocity_covariance_b.diagonal().minCoeff(), 0);
  EXPECT_GT(odometry->pose_covariance_w.diagonal().minCoeff(), 0);
}

// The base is 1 m behind the lidar and 2 m below it, and turned by 0.5 rad.
TEST(LiveDetector, OwnOdometryIsOfTheBaseFrame) {
  LiveOptions options = with_own_odometry();
  options.base_frame = "base_link";
  Robot robot(options);
  const SE3 T_vb(rotation_z(0.5), {-1, 0, -2});
  robot.live().add_transform("base_link", "lidar", Time(), T_vb.inverse(), true);
  robot.drive(0, 12);
  Robot plain(with_own_odometry());
  plain.drive(0, 12);
  const auto base = live_odometry(robot.outputs().back());
  const auto lidar = live_odometry(plain.outputs().back());
  ASSERT_TRUE(base && lidar);
  EXPECT_EQ(robot.outputs().back().body_frame, "base_link");
  const SE3 expected = T_vb.inverse() * lidar->T_wb * T_vb;  // both begin with the identity
  EXPECT_LT((base->T_wb.matrix() - expected.matrix()).cwiseAbs().maxCoeff(), 1e-9);
  // Of a point of a rigid body: v + w x r, in the axes of the base.
  const Eigen::Vector3d v = lidar->velocity_b.head<3>(), w = lidar->velocity_b.tail<3>();
  const Eigen::Vector3d v_base = rotation_z(-0.5) * (v + w.cross(T_vb.translation()));
  EXPECT_LT((base->velocity_b.head<3>() - v_base).norm(), 1e-9);
}

TEST(LiveDetector, WithoutItsBaseThereIsNoOdometry) {
  LiveOptions options = with_own_odometry();
  options.base_frame = "base_link";
  Robot robot(options);
  robot.drive(0, 12);
  ASSERT_FALSE(robot.outputs().empty());
  EXPECT_FALSE(live_odometry(robot.outputs().back()));
  EXPECT_THAT(robot.diagnostics().message, HasSubstr("no transforms lead from frame lidar to base_link"));
}

TEST(LiveDetector, AnUnpluggedSensorIsReportedAndItsReturnTaken) {
  Robot robot(with_own_odometry());
  EXPECT_THAT(robot.diagnostics().message, HasSubstr("no cloud yet on topic points"));
  robot.drive(0, 14);
  robot.pass_ms(3000);
  EXPECT_EQ(robot.diagnostics().level, LiveLevel::error);
  EXPECT_THAT(robot.diagnostics().message, HasSubstr("no cloud on topic points for 3.0 s"));
  const SE3 before = live_odometry(robot.outputs().back())->T_wb;
  const auto shift = Duration::from_seconds(3);
  EXPECT_LE(robot.turns_until_labels(0, at_ms(1000 + kTurnMs * 14), shift), kCloudsToRecover);
  EXPECT_THAT(robot.live().take_events().back().text, testing::Not(testing::IsEmpty()));
  // The own odometry goes on from its last pose, not from 0.
  const SE3 after = live_odometry(robot.outputs().back())->T_wb;
  EXPECT_GT(before.translation().norm(), 5);
  EXPECT_LT((after.translation() - before.translation()).norm(), 25);
  EXPECT_GT(after.translation().norm(), before.translation().norm());
}

class LiveDetectorJump : public testing::TestWithParam<double> {};

// A clock set while the sensor runs, a bag that begins anew, a driver that counts from its own start.
TEST_P(LiveDetectorJump, AJumpOfTheStampsBeginsAnew) {
  const auto robot = driving(10);
  (void)robot->live().take_events();
  const auto shift = Duration::from_seconds(GetParam());
  const Time from = at_ms(1000 + kTurnMs * 10);
  for (int ms = 1000; ms <= 4000; ms += 50) {
    const SE3 T_0v = street().trajectory->at(at_ms(ms - 1000)).T_v0.inverse();
    robot->live().add_transform("odom", "base_link", from + shift + (at_ms(ms) - at_ms(1000)), T_0v, false);
  }
  EXPECT_LE(robot->turns_until_labels(0, from, shift), kCloudsToRecover);
  std::string log;
  for (const LiveEvent& event : robot->live().take_events()) log += event.text + "\n";
  EXPECT_THAT(log, HasSubstr("detection begins anew"));
}

INSTANTIATE_TEST_SUITE_P(By, LiveDetectorJump, testing::Values(100.0, -1.3, -50.0, 1.7e9));

TEST(LiveDetector, EmptyCloudsAreReportedAndPassedOver) {
  const auto robot = driving(10);
  PointCloud2 empty = cloud(10);
  empty.view.width = 0;
  empty.view.row_step = 0;
  empty.view.data = {};
  robot->turn(std::move(empty));
  EXPECT_THAT(robot->diagnostics().message, HasSubstr("a cloud without points"));
  EXPECT_EQ(robot->turn(cloud(11)), 1U);
  robot->pass_ms(2100);
  robot->add(cloud(12));
  EXPECT_THAT(robot->diagnostics().message, testing::Not(HasSubstr("without points")));
}

// The time of the arrival takes the place of the stamp; that the clouds are late by turns is no other rate.
TEST(LiveDetector, CloudsWithoutAStampAreLabelledByTheirArrival) {
  Robot robot(with_own_odometry());
  for (int k = 0; k < kScans; ++k) {
    PointCloud2 next = cloud(k);
    next.view.stamp = Time();
    if (k < kScans / 2) robot.pass_ms(20);
    robot.turn(std::move(next));
  }
  EXPECT_THAT(robot.diagnostics().message, HasSubstr("have no stamp: the time of their arrival is used"));
  EXPECT_THAT(robot.diagnostics().message, testing::Not(HasSubstr("begins anew")));
  ASSERT_EQ(robot.outputs().size(), kScans - 1U);  // the last waits for a next one
  EXPECT_EQ(robot.outputs().back().cloud.view.stamp,
            at_ms(500'000 + 20 * kScans / 2 + kTurnMs * (kScans - 1)));
}

TEST(LiveDetector, ACloudWithTheStampOfTheLastIsReportedAndPassedOver) {
  const auto robot = driving(10);
  robot->turn(cloud(9));
  EXPECT_THAT(robot->diagnostics().message, HasSubstr("a cloud with the stamp of the one before is ignored"));
  EXPECT_EQ(robot->turn(cloud(10)), 1U);
}

TEST(LiveDetector, ACloudThatIsNoneIsReportedAndTheNextTaken) {
  const auto robot = driving(10);
  PointCloud2 cut = cloud(10);
  cut.view.data = cut.view.data.first(100);
  robot->turn(std::move(cut));
  EXPECT_THAT(robot->diagnostics().message, AllOf(HasSubstr("points: data = 100 bytes"), HasSubstr("need")));
  EXPECT_EQ(robot->diagnostics().level, LiveLevel::error);
  EXPECT_EQ(robot->value("unusable"), "1");
  EXPECT_EQ(robot->turn(cloud(11)), 1U);
}

TEST(LiveDetector, OtherFieldsBeginAnew) {
  const auto robot = driving(10);
  const std::size_t before = robot->outputs().size();
  for (int k = 10; k < 20; ++k)
    robot->turn(cloud_of(scans()[static_cast<std::size_t>(k)], at_ms(1000 + kTurnMs * k), "t"));
  EXPECT_THAT(robot->diagnostics().message, HasSubstr("the clouds have other fields now"));
  EXPECT_EQ(robot->outputs().size(), before + 1 + 9);  // the one that was held back, and the new ones but one
}

// An organised cloud, as of Ouster: the driver starts again with half of the columns.
TEST(LiveDetector, AnotherResolutionBeginsAnew) {
  const auto organised = [](int k, std::uint32_t width) {
    PointCloud2 one = cloud(k);
    one.view.height = 2;
    one.view.width = width;
    one.view.row_step = width * kStep;
    return one;
  };
  const auto robot = driving(10);
  for (int k = 10; k < 12; ++k) robot->turn(organised(k, 2000));
  EXPECT_THAT(robot->diagnostics().message, HasSubstr("the clouds have 2 x 2000 points now, before 1 x "));
  const std::size_t before = robot->outputs().size();
  for (int k = 12; k < 20; ++k) robot->turn(organised(k, 1000));
  EXPECT_THAT(robot->diagnostics().message,
              HasSubstr("the clouds have 2 x 1000 points now, before 2 x 2000"));
  EXPECT_GE(robot->outputs().size(), before + 6);  // eight clouds: less than a second
}

// Half of the clouds, and more, are lost in the network.
TEST(LiveDetector, LostCloudsAreNotTakenForAnotherRate) {
  const auto robot = driving(8);
  for (const int k : {8, 10, 12, 13, 15, 17, 20, 23}) {
    robot->pass_ms(kTurnMs);
    EXPECT_EQ(robot->turn(cloud(k)), 1U) << k;
  }
  EXPECT_EQ(robot->diagnostics().level, LiveLevel::ok) << robot->diagnostics().message;
}

TEST(LiveDetector, AnotherRateBeginsAnew) {
  const auto robot = driving(8);
  for (int i = 0; i < 16; ++i) {
    PointCloud2 next = cloud(8 + i);
    next.view.stamp = at_ms(1000 + kTurnMs * 8 + 2 * kTurnMs * i);
    robot->turn(std::move(next));
  }
  std::string log;
  for (const LiveEvent& event : robot->live().take_events()) log += event.text + "\n";
  EXPECT_THAT(log, HasSubstr("the clouds come every 200 ms now, before every 100 ms"));
}

// The driver dies, and starts again a second later.
TEST(LiveDetector, ADriverThatStartsAgainIsTaken) {
  const auto robot = driving(8);
  robot->pass_ms(700);
  EXPECT_EQ(robot->turn(cloud(16), 2), 1U);
  std::string log;
  for (const LiveEvent& event : robot->live().take_events()) log += event.text + "\n";
  EXPECT_THAT(log, HasSubstr("come from another publisher now"));
}

TEST(LiveDetector, ASecondPublisherIsIgnoredAndReported) {
  const auto robot = driving(8);
  const std::size_t before = robot->outputs().size();
  for (int k = 8; k < 14; ++k) {
    robot->add(cloud_of(scans()[0], at_ms(1030 + kTurnMs * k)), 2);
    EXPECT_EQ(robot->turn(cloud(k)), 1U);
  }
  EXPECT_EQ(robot->outputs().size(), before + 6);
  EXPECT_EQ(robot->value("of_second_publisher"), "6");
  EXPECT_THAT(robot->diagnostics().message, HasSubstr("a second publisher on topic points"));
}

TEST(LiveDetector, CloudsWaitForLatePoses) {
  Robot robot(with_poses());
  add_poses(robot, 1000, 1000 + kTurnMs * 8);
  robot.drive(0, 8);
  const std::size_t before = robot.outputs().size();
  EXPECT_GE(before, 6U);
  robot.turn(cloud(8));
  EXPECT_EQ(robot.outputs().size(), before);
  add_poses(robot, 1000 + kTurnMs * 8, 1000 + kTurnMs * 9 + 50);
  EXPECT_EQ(robot.process(), 1U);
  EXPECT_EQ(robot.diagnostics().level, LiveLevel::ok) << robot.diagnostics().message;
}

TEST(LiveDetector, MissingPosesAreReportedAndTheirReturnTaken) {
  Robot robot(with_poses());
  robot.drive(0, 8);
  EXPECT_TRUE(robot.outputs().empty());
  EXPECT_EQ(robot.diagnostics().level, LiveLevel::error);
  EXPECT_THAT(robot.diagnostics().message,
              AllOf(HasSubstr("no transforms lead from frame lidar to odom"), HasSubstr("none")));
  add_poses(robot, 1000, 1000 + kTurnMs * kScans);
  robot.drive(8, 16);
  EXPECT_GE(robot.outputs().size(), 7U);
}

TEST(LiveDetector, IdsOfObjectsAreNotReused) {
  const auto robot = driving(10);
  std::uint32_t largest = 0;
  for (const LiveOutput& output : robot->outputs())
    for (const LiveObject& object : live_objects(output)) largest = std::max(largest, object.id);
  ASSERT_GT(largest, 0U);
  (void)robot->live().reset();
  const std::size_t before = robot->outputs().size();
  robot->drive(10, 20);
  for (std::size_t i = before; i < robot->outputs().size(); ++i) {
    for (const LiveObject& object : live_objects(robot->outputs()[i])) EXPECT_GT(object.id, largest);
  }
  EXPECT_GT(robot->outputs().size(), before);
}

// As in a node: clouds, poses and diagnostics on other threads than the detection.
TEST(LiveDetectorThreads, CloudsComeOnAnotherThread) {
  LiveOptions options = with_poses();
  options.live.pose_wait_s = 10;
  options.live.queue_clouds = 12;  // none is dropped
  LiveDetector live(options);
  constexpr std::size_t kClouds = 12;
  (void)scans();
  std::atomic<bool> done = false;
  std::thread middleware([&] {
    for (std::size_t k = 0; k < kClouds; ++k) {
      live.add_cloud(cloud(static_cast<int>(k)), 1);
      for (int ms = 0; ms < 2 * kTurnMs; ms += kTurnMs / 2) {
        const int at = 1000 + 2 * kTurnMs * static_cast<int>(k) + ms;
        const SE3 T_0v = street().trajectory->at(at_ms(at - 1000)).T_v0.inverse();
        live.add_transform("odom", "lidar", at_ms(at), T_0v, false);
      }
      (void)live.diagnostics();
    }
    done = true;
  });
  std::vector<LiveOutput> outputs;
  const auto append = [&](std::vector<LiveOutput> more) {
    for (LiveOutput& output : more) outputs.push_back(std::move(output));
  };
  while (!done || outputs.size() + 1 < kClouds) {
    live.wait(Duration::from_seconds(0.01));
    append(live.process());
  }
  middleware.join();
  append(live.reset());
  EXPECT_EQ(outputs.size(), kClouds);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
