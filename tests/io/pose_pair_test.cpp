#include "io/self_check/pose_pair.hpp"

#include <algorithm>
#include <optional>

#include <gtest/gtest.h>

#include "support/toy_scene.hpp"

namespace mapless {
namespace MAPLESS_FILE {

// Of T_0v = exp(t varpi): forward.
Vector6d forward(double speed) {
  Vector6d velocity = Vector6d::Zero();
  velocity[0] = speed;
  return velocity;
}

// The sensor passes a column of lorries, which drive at 4 m/s, at 6 m/s; on the other side there are houses.
test::ToyScene lorries_and_houses() {
  test::ToyScene scene = test::toy_street("VLP-16");
  scene.trajectory = test::drive(6, 0);
  scene.world = {test::toy_ground(-1.8)};
  for (int i = -6; i <= 8; ++i) {
    scene.world.push_back(test::toy_box({8.0 * i, -9, 2}, {2.5, 2, 4}));
    test::ToyBody lorry = test::toy_box({5.0 * i, 4, 0}, {1.5, 1, 1.8});
    lorry.velocity_0 = {4, 0, 0};
    scene.world.push_back(lorry);
  }
  return scene;
}

Motion constant(const Vector6d& velocity) {
  return [velocity](Time t) -> std::optional<SE3> { return SE3::exp(t.seconds() * velocity); };
}

// Relative to the lorries the sensor drives at 2 m/s, relative to the houses at 6 m/s: each motion brings its
// own things onto themselves, and motions beside it do not.
TEST(PosePair, TheMotionsOfVehiclesAndOfTheStaticWorldStandOut) {
  const test::ToyScene scene = lorries_and_houses();
  const test::ToyScan first = cast_scan(scene, 0), second = cast_scan(scene, 5);
  const PosePair pair(*first.scan, *second.scan);
  const auto right = pair.peaks(constant(forward(6)), forward(2));
  ASSERT_TRUE(right);
  EXPECT_GT(right->said, 5);
  EXPECT_GT(right->found, 3);
  // At 4 m/s, a metre from both, nothing is seen.
  const auto wrong = pair.peaks(constant(forward(4)), forward(6));
  ASSERT_TRUE(wrong);
  EXPECT_LT(wrong->said, 2);
  EXPECT_GT(wrong->found, 5);
}

// Loaded wagons that drive beside the sensor have a motion of their own, on their side alone.
TEST(PosePair, OneVehicleSpeaksFromOneHalfTurn) {
  test::ToyScene scene = test::toy_street("VLP-16");
  scene.trajectory = test::drive(6, 0);
  scene.world = {test::toy_ground(-1.8), test::toy_box({-6, -9, 2}, {2.5, 2, 4}),
                 test::toy_box({9, -9, 2}, {2.5, 2, 4}), test::toy_box({-14, 9, 2}, {2.5, 2, 4}),
                 test::toy_box({16, 9, 2}, {2.5, 2, 4})};
  for (int i = -2; i <= 3; ++i) {
    test::ToyBody wagon = test::toy_box({3.0 * i, 4, 0}, {1, 1, 1.8});
    wagon.velocity_0 = {3, 0, 0};
    scene.world.push_back(wagon);
  }
  const test::ToyScan first = cast_scan(scene, 0), second = cast_scan(scene, 5);
  const PosePair pair(*first.scan, *second.scan);
  EXPECT_TRUE(pair.one_sided(constant(forward(6)), forward(3))) << "relative to the wagons";
  const test::ToyScene room = test::toy_room("VLP-16", test::drive(1, 0));
  const test::ToyScan before = cast_scan(room, 0), after = cast_scan(room, 5);
  EXPECT_FALSE(PosePair(*before.scan, *after.scan).one_sided(constant(forward(3)), forward(1)))
      << "walls all around";
}

TEST(PosePair, AWrongMotionDoesNotStandOut) {
  const test::ToyScene room = test::toy_room("VLP-16", test::drive(1, 0));
  const test::ToyScan first = cast_scan(room, 0), second = cast_scan(room, 5);
  const PosePair pair(*first.scan, *second.scan);
  // 3 m/s for 1 m/s: a metre off after half a second. A turn of 0.4 rad.
  Vector6d turning = forward(1);
  turning[5] = 0.8;
  for (const Vector6d& wrong : {forward(3), turning}) {
    const auto peaks = pair.peaks(constant(wrong), forward(1));
    ASSERT_TRUE(peaks) << wrong.transpose();
    EXPECT_GT(peaks->found, 5) << wrong.transpose();
    EXPECT_LT(peaks->said, 2) << wrong.transpose();
  }
  EXPECT_FALSE(pair.peaks(constant(forward(2)), forward(1))) << "0.5 m apart";
  EXPECT_FALSE(pair.peaks([](Time) { return std::nullopt; }, forward(1)));
}

// Points of both scans fit the room under the right motion, and under none beside it.
TEST(PosePair, PrefersTheRightMotion) {
  const test::ToyScene room = test::toy_room("VLP-16", test::drive(2, 0));
  const test::ToyScan first = cast_scan(room, 0), second = cast_scan(room, 5);
  const PosePair pair(*first.scan, *second.scan);
  const Motion right = constant(forward(2)), wrong = constant(forward(2.6));
  const auto nowhere = [](Time) { return std::nullopt; };
  const std::vector<double> of_wrong = pair.preferences(wrong, {right, wrong, nowhere});
  EXPECT_GT(of_wrong[0], 5);
  EXPECT_EQ(of_wrong[1], 0);
  EXPECT_EQ(of_wrong[2], 0) << "does not cover the scans";
  EXPECT_LT(pair.preferences(right, {wrong})[0], -5);
}

// ScanPoses are evenly spaced from the start of a scan to its end.
TEST(PosePair, AsksForTheMotionUpToTheEndOfTheScans) {
  const test::ToyScene room = test::toy_room("VLP-16", test::drive(2, 0));
  const test::ToyScan first = cast_scan(room, 0), second = cast_scan(room, 5);
  std::optional<Time> last;
  (void)PosePair(*first.scan, *second.scan).blur_m([&](Time t) {
    last = last ? std::max(*last, t) : t;
    return std::optional(SE3());
  });
  EXPECT_EQ(last, second.scan->end());
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
