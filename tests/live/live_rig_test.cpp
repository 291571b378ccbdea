#include <algorithm>
#include <cstddef>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "live/live_robot.hpp"

namespace mapless {
namespace MAPLESS_FILE {

using test::at_ms;
using test::cloud;
using test::kScans;
using test::kTurnMs;
using test::Robot;
using test::street;
using test::with_own_odometry;
using test::with_poses;

// The sensor frame at the start of scan 0, which begins at 1 s on the clock of the clouds, from that at
// `time`.
SE3 true_pose(Time time) {
  const Trajectory& truth = *street().trajectory;
  return truth.at(at_ms(0)).T_v0 * truth.at(time - Duration::from_seconds(1)).T_v0.inverse();
}

TEST(LivePoses, FollowTheMotionWithinEachScan) {
  Robot robot(with_own_odometry());
  robot.drive(0, kScans);
  ASSERT_GT(robot.outputs().size(), 10U);
  Time last = at_ms(1000);
  for (const LiveOutput& output : robot.outputs()) {
    const std::vector<LivePose> poses = live_poses(output);
    ASSERT_EQ(poses.size(), 5U);
    EXPECT_EQ(poses.back().time, output.labelled.scan().end());
    for (const LivePose& pose : poses) {
      EXPECT_EQ(pose.time, last + Duration::from_nanoseconds(kTurnMs * 1'000'000 / 5));
      last = pose.time;
      EXPECT_LT((pose.T_wb.translation() - true_pose(pose.time).translation()).norm(), 0.03);
    }
  }
}

TEST(LiveTransforms, AreThePosesOrTheirInverse) {
  Robot robot(with_own_odometry());
  robot.drive(0, kScans);
  const LiveOutput& output = robot.outputs().back();
  const std::vector<LivePose> poses = live_poses(output);
  for (const bool inverted : {false, true}) {
    SCOPED_TRACE(inverted);
    const std::vector<LiveTransform> transforms = live_transforms(output, inverted);
    ASSERT_EQ(transforms.size(), poses.size());
    for (std::size_t i = 0; i < poses.size(); ++i) {
      EXPECT_EQ(transforms[i].time, poses[i].time);
      EXPECT_EQ(transforms[i].parent, inverted ? "lidar" : "odom");
      EXPECT_EQ(transforms[i].child, inverted ? "odom" : "lidar");
      const SE3 T_wb = inverted ? transforms[i].T_parent_child.inverse() : transforms[i].T_parent_child;
      EXPECT_TRUE(T_wb.matrix().isApprox(poses[i].T_wb.matrix(), 1e-9));
    }
  }
}

// The second lidar has the clouds of the first, as if it stood in its place, on a clock that is 250 ms
// behind.
TEST(LiveRig, AnotherLidarIsLabelledAlongTheMotionOfTheFirst) {
  const Duration behind = Duration::from_seconds(0.25);
  LiveOptions options = with_poses();
  options.live.clock_offset_s = behind.seconds();
  options.live.pose_wait_s = 9;
  Robot first(with_own_odometry()), second(options);
  std::size_t given = 0;
  for (int k = 0; k < kScans; ++k) {
    first.turn(cloud(k));
    for (; given < first.outputs().size(); ++given) {
      for (const LivePose& pose : live_poses(first.outputs()[given]))
        second.live().add_transform("odom", "lidar", pose.time, pose.T_wb, false);
    }
    PointCloud2 later = cloud(k);
    later.view.stamp = later.view.stamp - behind;
    second.turn(std::move(later));
    second.process();
  }
  // All but the first cloud, whose beginning is before the first pose: the others do not wait behind it.
  ASSERT_GT(first.outputs().size(), 20U);
  ASSERT_GE(second.outputs().size() + 3, first.outputs().size());
  std::size_t moving = 0, different = 0;
  for (std::size_t i = 4; i < second.outputs().size(); ++i) {  // after the detector's own start
    const LiveOutput& one = second.outputs()[i];
    const auto other = std::find_if(first.outputs().begin(), first.outputs().end(), [&](const LiveOutput& o) {
      return o.cloud.view.stamp == one.cloud.view.stamp + behind;
    });
    ASSERT_NE(other, first.outputs().end());
    EXPECT_EQ(one.labelled.scan().start, other->labelled.scan().start);
    const std::vector<PointMotion> a = point_motions(one), b = point_motions(*other);
    for (std::size_t p = 0; p < a.size(); ++p) {
      moving += b[p] == PointMotion::moving ? 1 : 0;
      different += a[p] == b[p] ? 0 : 1;
    }
  }
  EXPECT_GT(moving, 500U);
  EXPECT_LT(static_cast<double>(different), 0.01 * static_cast<double>(moving));
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
