#include "odometry/map/edge_grid.hpp"

#include <limits>
#include <random>

#include <gtest/gtest.h>

namespace mapless {
namespace MAPLESS_FILE {

using Points = std::vector<Eigen::Vector3d>;

Points anywhere(unsigned seed, int count) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> metres(-4, 4);
  Points out;
  for (int i = 0; i < count; ++i) out.emplace_back(metres(random), metres(random), metres(random));
  return out;
}

// Squared distance to the nearest of all points.
double nearest_square(const Points& points, const Eigen::Vector3d& p) {
  double out = std::numeric_limits<double>::infinity();
  for (const Eigen::Vector3d& one : points) out = std::min(out, (one - p).squaredNorm());
  return out;
}

// Against brute force, with the points inserted in two parts.
TEST(EdgeGrid, FindsTheNearestEdgeWithinItsReach) {
  const Points edges = anywhere(1, 900), queries = anywhere(2, 500);
  EdgeGrid grid;
  grid.insert({edges.begin(), edges.begin() + 300});
  grid.insert({edges.begin() + 300, edges.end()});
  const double reach = EdgeGrid::kReach_m * EdgeGrid::kReach_m;
  double agreement = 0;
  int found = 0;
  for (const Eigen::Vector3d& p : queries) {
    const double expected = nearest_square(edges, p);
    const Eigen::Vector3d* nearest = grid.nearest(p);
    ASSERT_EQ(nearest != nullptr, expected < reach);
    if (nearest == nullptr) continue;
    ++found;
    EXPECT_DOUBLE_EQ((*nearest - p).squaredNorm(), expected);
    agreement += 1 - expected / reach;
  }
  EXPECT_GT(found, 100);
  EXPECT_LT(found, 400);
  EXPECT_NEAR(grid.agreement(queries), agreement, 1e-9);
}

TEST(EdgeGrid, EmptyAgreesWithNothing) {
  EXPECT_EQ(EdgeGrid().nearest({0, 0, 0}), nullptr);
  EXPECT_EQ(EdgeGrid().agreement(anywhere(3, 10)), 0);
}

// weight = 1 - (0.2 / 0.4)^2 for every edge of a grid of 1 m, all moved by 0.2 m.
TEST(EdgeAgreement, IsTheMeanWeight) {
  Points edges;
  for (int x = 0; x < 10; ++x)
    for (int y = 0; y < 10; ++y) edges.emplace_back(x, y, 0);
  Points moved = edges;
  for (Eigen::Vector3d& p : moved) p.z() += 0.2;
  EXPECT_NEAR(*edge_agreement(edges, edges), 1, 1e-12);
  EXPECT_NEAR(*edge_agreement(edges, moved), 0.75, 1e-12);
  moved.resize(50);
  for (int i = 0; i < 25; ++i) moved[static_cast<std::size_t>(i)].z() += 1;
  EXPECT_NEAR(*edge_agreement(edges, moved), 0.375, 1e-12);
}

TEST(EdgeAgreement, IsNotKnownFromFewEdges) {
  const Points few(49, Eigen::Vector3d::Zero()), enough(50, Eigen::Vector3d::Zero());
  EXPECT_FALSE(edge_agreement(few, enough));
  EXPECT_FALSE(edge_agreement(enough, few));
  EXPECT_TRUE(edge_agreement(enough, enough));
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
