#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <mapless/geometry/compensated_scan.hpp>

namespace mapless {
namespace MAPLESS_FILE {

using testing::ElementsAre;

TEST(VoxelMap, HasTheMeanOfEachVoxel) {
  VoxelMap map(1.0);  // voxels begin at the first point
  EXPECT_TRUE(map.add({10, 0, 0}));
  EXPECT_TRUE(map.add({10.5, 0.5, 0}));
  EXPECT_TRUE(map.add({9.5, 0, 0}));
  EXPECT_TRUE(map.add({10.25, 0.25, 0.75}));
  const ExportCloud cloud = map.cloud();
  ASSERT_EQ(cloud.points.size(), 2U);
  EXPECT_TRUE(cloud.points[0].isApprox(Eigen::Vector3d(10.25, 0.25, 0.25)));
  EXPECT_TRUE(cloud.points[1].isApprox(Eigen::Vector3d(9.5, 0, 0)));
  EXPECT_THAT(cloud.columns.front().values, ElementsAre(3, 1));
}

// A million voxels of 1 mm are 1 km.
TEST(VoxelMap, LeavesOutAPointBeyondItsKeys) {
  VoxelMap map(0.001);
  EXPECT_TRUE(map.add({0, 0, 0}));
  EXPECT_FALSE(map.add({2000, 0, 0}));
  EXPECT_EQ(map.size(), 1U);
}

TEST(VoxelMap, AFullOneTakesPointsOfItsVoxelsAlone) {
  VoxelMap map(1.0, 2);
  EXPECT_TRUE(map.add({0.5, 0, 0}));
  EXPECT_TRUE(map.add({5.5, 0, 0}));
  EXPECT_FALSE(map.add({9.5, 0, 0}));
  EXPECT_TRUE(map.add({5.75, 0, 0}));
  EXPECT_THAT(map.cloud().columns.front().values, ElementsAre(1, 2));
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
