#include "io/self_check/pose_pair.hpp"

#include <algorithm>

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

// Relative to the lorries the sensor drives at 2 m/s, relative to the houses at 6 m/s: each motion brings its
// own things onto themselves, and motions as far off bring none.
TEST(PosePair, VehiclesAndTheStaticWorldSupportTheirOwnMotions) {
  const test::ToyScene scene = lorries_and_houses();
  const test::ToyScan first = cast_scan(scene, 0), second = cast_scan(scene, 5);
  const PosePair::Support s = PosePair(*first.scan, *second.scan).support(forward(6), forward(2));
  EXPECT_GT(s.points, 100);
  EXPECT_GT(s.said, 0.15);
  EXPECT_GT(s.found, 0.15);
  EXPECT_GT(std::min(s.said, s.found), 2 * s.chance);
}

TEST(PosePair, NothingSupportsAWrongMotion) {
  const test::ToyScene room = test::toy_room("VLP-16", test::drive(1, 0));
  const test::ToyScan first = cast_scan(room, 0), second = cast_scan(room, 5);
  const PosePair pair(*first.scan, *second.scan);
  const PosePair::Support s = pair.support(forward(3), forward(1));
  EXPECT_GT(s.points, 100);
  EXPECT_GT(s.found, 0.6);
  EXPECT_LT(s.said, 0.1);
  EXPECT_EQ(pair.support(forward(1), forward(1)).points, 0) << "they differ nowhere";
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
