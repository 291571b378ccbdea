#include <algorithm>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "live/live_robot.hpp"

namespace mapless {
namespace MAPLESS_FILE {

using testing::HasSubstr;

using test::add_poses;
using test::at_ms;
using test::cloud;
using test::driving;
using test::kScans;
using test::kTurnMs;
using test::Robot;
using test::with_poses;

// Three clouds come in the time that one takes.
TEST(LiveOverload, OverloadDropsTheOldestEvenlyAndSaysSo) {
  const auto robot = driving(6);
  const std::size_t before = robot->outputs().size();
  for (int k = 6; k < kScans; ++k) {
    robot->add(cloud(k));
    robot->pass_ms(kTurnMs);
    EXPECT_LE(std::stoul(robot->value("waiting")), 5U);  // queue_clouds
    if (k % 3 == 0) (void)robot->process();
  }
  for (int i = 0; i < 8; ++i) (void)robot->process();
  std::int64_t longest_ms = 0;
  for (std::size_t i = before + 1; i < robot->outputs().size(); ++i) {
    const Duration step = robot->outputs()[i].cloud.view.stamp - robot->outputs()[i - 1].cloud.view.stamp;
    longest_ms = std::max(longest_ms, step.nanoseconds() / 1'000'000);
  }
  EXPECT_EQ(longest_ms, 3 * kTurnMs);
  EXPECT_EQ(robot->outputs().back().cloud.view.stamp, at_ms(1000 + kTurnMs * (kScans - 2)));  // the newest
  EXPECT_EQ(std::stoul(robot->value("dropped")) + robot->outputs().size() + 1, std::size_t{kScans});
  EXPECT_GT(std::stoul(robot->value("dropped")), 4U);
  EXPECT_THAT(robot->diagnostics().message, HasSubstr("overload"));
}

// A turn takes 1.4 times as long to process as to measure, for a long time: two of seven clouds are dropped,
// never two in a row, and no cloud is kept but those that wait and the one whose labels need the next.
TEST(LiveOverload, ALongOverloadDropsEvenlyAndKeepsNothing) {
  constexpr int kClouds = 210;
  Robot robot(with_poses());
  robot.live().add_transform("odom", "lidar", Time(), SE3(), true);
  std::vector<std::weak_ptr<const void>> clouds;
  std::vector<Time> labelled;
  for (int k = 0; k < kClouds; ++k) {
    robot.pass_ms(kTurnMs);
    PointCloud2 next = test::cloud_of(test::scans()[static_cast<std::size_t>(k % kScans)],
                                      at_ms(1000 + std::int64_t{kTurnMs} * k));
    clouds.push_back(next.owner);
    robot.add(std::move(next));
    if (k % 7 != 3 && k % 7 != 6) {  // five of seven
      for (const LiveOutput& output : robot.live().process()) labelled.push_back(output.cloud.view.stamp);
    }
    const auto is_kept = [](const std::weak_ptr<const void>& cloud) { return !cloud.expired(); };
    ASSERT_LE(std::count_if(clouds.begin(), clouds.end(), is_kept), 5 + 1) << k;  // queue_clouds
  }
  EXPECT_THAT(robot.diagnostics().message, HasSubstr("overload"));
  const std::size_t waiting = std::stoul(robot.value("waiting")),
                    dropped = std::stoul(robot.value("dropped"));
  EXPECT_EQ(labelled.size() + 1 + waiting + dropped, clouds.size());
  EXPECT_EQ(waiting, 5U);
  const auto settled = labelled.end() - 100;  // the queue is full long before
  for (auto one = settled; one + 1 != labelled.end(); ++one)
    EXPECT_LE(*(one + 1) - *one, Duration::from_nanoseconds(2 * kTurnMs * 1'000'000LL));
  EXPECT_EQ((labelled.back() - *settled).nanoseconds() / 1'000'000 / kTurnMs, 139);  // 99 x 7 / 5, rounded up
}

// A node waits for its driver longer than a start may last.
TEST(LiveOverload, TheStartBeginsWithTheFirstCloud) {
  Robot robot(with_poses());
  add_poses(robot, 1000, 1000 + kTurnMs * kScans);
  for (int i = 0; i < 10; ++i) {
    robot.pass_ms(1000);
    EXPECT_EQ(robot.process(), 0U);
  }
  for (int k = 0; k < 8; ++k) robot.add(cloud(k));  // more than queue_clouds
  for (int k = 0; k < 8; ++k) robot.process();
  EXPECT_EQ(robot.value("dropped"), "0");
  EXPECT_EQ(robot.outputs().size(), 7U);
}

// The fifth cloud brings the first labels (start_scans = 5). Of the 15 that wait then every other one goes
// until 5 wait (queue_clouds): 5, 7, 9, 11 and 13.
TEST(LiveOverload, ALongStartIsCaughtUpEvenlyAndSaysSo) {
  Robot robot(with_poses());
  add_poses(robot, 1000, 1000 + kTurnMs * kScans);
  for (int k = 0; k < 20; ++k) robot.add(cloud(k));
  for (int k = 0; k < 15; ++k) robot.process();
  EXPECT_EQ(robot.value("dropped"), "5");
  EXPECT_THAT(robot.diagnostics().message, HasSubstr("the start took long: 5 of the clouds"));
  EXPECT_THAT(robot.diagnostics().message, testing::Not(HasSubstr("overload")));
  std::vector<std::int64_t> labelled;
  for (const LiveOutput& output : robot.outputs())
    labelled.push_back((output.cloud.view.stamp - at_ms(1000)).nanoseconds() / 1'000'000 / kTurnMs);
  EXPECT_THAT(labelled, testing::ElementsAre(0, 1, 2, 3, 4, 6, 8, 10, 12, 14, 15, 16, 17, 18));
}

// The labels of the last cloud wait for a next one that never comes: that is no latency.
TEST(LiveOverload, LabelsOfAResetAreNotCountedAsLate) {
  const auto robot = driving(8);
  robot->pass_ms(5000);
  EXPECT_EQ(robot->live().reset().size(), 1U);
  EXPECT_EQ(robot->value("latency_max_ms"), "0.0");
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
