#include "detection/freespace/object_sight.hpp"

#include <gtest/gtest.h>

#include "support/toy_scene.hpp"

namespace mapless {
namespace MAPLESS_FILE {

using Eigen::Vector3d;

// A wall 12 m ahead and a post before it; the sensor drives and turns meanwhile.
class SightLinesTest : public testing::Test {
 protected:
  SightLinesTest() {
    scene.model = std::make_shared<const LidarModel>(named_model("OS1-64"));
    scene.trajectory = test::drive(5, 0.5);
    scene.world = {test::toy_box({12.5, 0, 0}, {0.5, 20, 8}), test::toy_box({6, 2, 0}, {0.3, 0.3, 3})};
  }
  [[nodiscard]] SightLines sight(ReturnCode empty = ReturnCode::nothing) {
    scene.empty_code = empty;
    const auto scan = test::cast_scan(scene, 3).scan;
    const Time middle = scan->column_time(scan->columns / 2);
    return {scan, scene.trajectory->at(middle), middle};
  }
  test::ToyScene scene;
};

TEST_F(SightLinesTest, LooksThroughWhatIsBeforeTheWallAlone) {
  const SightLines lines = sight();
  EXPECT_TRUE(lines.through({7, -2, 0.5}));
  EXPECT_TRUE(lines.through({10, -1, 0}));
  EXPECT_FALSE(lines.through({12, -1, 0})) << "on the wall";
  EXPECT_FALSE(lines.through({11.8, -1, 0})) << "too near to it to tell";
  EXPECT_FALSE(lines.through({14, -1, 0})) << "behind it";
  EXPECT_FALSE(lines.through({5.7, 2, 0})) << "on the post";
  EXPECT_FALSE(lines.through({3, 0, 30})) << "above all rays";
}

TEST_F(SightLinesTest, OpenSkyIsLookedThroughAndAFaultyReturnIsNot) {
  EXPECT_TRUE(sight().through({-20, 3, 1}));
  EXPECT_FALSE(sight(ReturnCode::faulty).through({-20, 3, 1}));
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
