#include "odometry/voxel_map.hpp"

#include <cmath>
#include <limits>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

namespace mapless {
namespace {

using Eigen::Vector3d;

void insert_plane(VoxelMap& map, const Vector3d& centre, const Vector3d& u, const Vector3d& v) {
  for (int i = -10; i <= 10; ++i) {
    for (int j = -10; j <= 10; ++j) map.insert(centre + 0.15 * i * u + 0.15 * j * v);
  }
}

TEST(VoxelMap, FindsThePlaneOfItsPoints) {
  const Vector3d u = Vector3d(1, 0.2, 0.1).normalized();
  const Vector3d normal = u.cross(Vector3d(0, 1, 0.3)).normalized();
  // Far from the origin, too: 30 km away a float has steps of 2 mm.
  for (const Vector3d& centre :
       {Vector3d(0, 0, 0), Vector3d(12.3, -45.6, 7.8), Vector3d(30000.2, -20000, 5)}) {
    VoxelMap map;
    insert_plane(map, centre, u, normal.cross(u));
    const auto plane = map.plane_near(centre + 0.2 * normal);
    ASSERT_TRUE(plane);
    EXPECT_NEAR(std::abs(plane->normal_0.dot(normal)), 1, 1e-6);
    EXPECT_NEAR((plane->point_0 - centre).dot(normal), 0, 1e-5);
    EXPECT_GT(plane->planarity, 0.5);
  }
}

TEST(VoxelMap, CubesAtTheOriginAreAsWideAsOthers) {
  VoxelMap map;
  for (const double x : {-0.5, 0.5, 1.5}) map.insert({x, 0.5, 0.5});
  EXPECT_EQ(map.voxels(), 3u);
}

TEST(VoxelMap, KeepsDistanceAndLimit) {
  VoxelMap map;
  map.insert({0.5, 0.5, 0.5});
  map.insert({0.55, 0.5, 0.5});
  EXPECT_EQ(map.points(), 1u);
  for (int i = 0; i < 10; ++i) {
    for (int j = 0; j < 10; ++j) map.insert({0.05 + 0.1 * i, 0.05 + 0.1 * j, 0.9});
  }
  EXPECT_EQ(map.points(), std::size_t{VoxelMap::kSlots});
}

TEST(VoxelMap, HasNoPlaneFromFewPointsOrALine) {
  VoxelMap map;
  for (int i = 0; i < 9; ++i) map.insert({0.1 * i + 0.05, 0.3 * (i % 3), 0.5});
  EXPECT_FALSE(map.plane_near({0.5, 0.5, 0.5}));
  VoxelMap line;
  for (int i = 0; i < 20; ++i) line.insert({0.11 * i, 0.5, 0.5});
  const auto plane = line.plane_near({1, 0.5, 0.5});
  ASSERT_TRUE(plane);
  EXPECT_LT(plane->planarity, 1e-3);
}

TEST(VoxelMap, ForgetsWhatIsFar) {
  VoxelMap map;
  for (int x = 0; x < 3000; ++x) map.insert({x + 0.5, 0.5, 0.5});
  map.keep_within({1000, 0, 0}, 100);
  EXPECT_EQ(map.voxels(), 201u);
  map.insert({1000.9, 0.5, 0.5});
  EXPECT_EQ(map.voxels(), 201u) << "the table still finds them";
}

TEST(VoxelMap, IgnoresPointsThatAreNowhere) {
  VoxelMap map;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  map.insert({nan, 0, 0});
  map.insert({0, 1e300, 0});
  map.insert({0, 0, -std::numeric_limits<double>::infinity()});
  EXPECT_EQ(map.voxels(), 0u);
  EXPECT_FALSE(map.plane_near({nan, 0, 0}));
}

}  // namespace
}  // namespace mapless
