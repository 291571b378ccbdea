#include "geometry/nearest_neighbours.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <mapless/core/errors.hpp>

namespace mapless {
namespace MAPLESS_FILE {

using Points = std::vector<Eigen::Vector3d>;
using testing::ElementsAre;
using testing::IsEmpty;

// The obvious version: all squared distances, sorted by distance and then by index.
std::vector<NearestNeighbours::Neighbour> exhaustive(const Points& points, const Eigen::Vector3d& q) {
  std::vector<NearestNeighbours::Neighbour> all;
  for (std::size_t i = 0; i < points.size(); ++i) {
    all.push_back({static_cast<std::int32_t>(i), (points[i] - q).squaredNorm()});
  }
  std::sort(all.begin(), all.end(), [](const auto& a, const auto& b) {
    return a.distance_m < b.distance_m || (a.distance_m == b.distance_m && a.index < b.index);
  });
  for (auto& n : all) n.distance_m = std::sqrt(n.distance_m);
  return all;
}

void expect_same_as_exhaustive(const Points& points, const Points& queries, double radius_m) {
  const NearestNeighbours tree(points);
  for (const Eigen::Vector3d& q : queries) {
    SCOPED_TRACE(testing::Message() << "query " << q.transpose());
    const auto expected = exhaustive(points, q);
    ASSERT_EQ(tree.nearest(q).index, expected.front().index);
    ASSERT_DOUBLE_EQ(tree.nearest(q).distance_m, expected.front().distance_m);
    for (const std::size_t hint : {std::size_t{0}, points.size() / 2, points.size() - 1}) {
      const auto found = tree.nearest(q, {static_cast<std::int32_t>(hint), 0});
      ASSERT_EQ(found.index, expected.front().index) << "with hint " << hint;
      ASSERT_DOUBLE_EQ(found.distance_m, expected.front().distance_m);
    }
    const auto several = tree.nearest(q, 20);
    ASSERT_EQ(several.size(), std::min<std::size_t>(20, points.size()));
    for (std::size_t i = 0; i < several.size(); ++i) {
      ASSERT_EQ(several[i].index, expected[i].index) << i;
      ASSERT_DOUBLE_EQ(several[i].distance_m, expected[i].distance_m) << i;
    }
    std::vector<std::int32_t> near = {-7};
    tree.within(q, radius_m, near);
    std::vector<std::int32_t> expected_near;
    for (const auto& n : expected) {
      if (n.distance_m <= radius_m) expected_near.push_back(n.index);
    }
    std::sort(expected_near.begin(), expected_near.end());
    ASSERT_EQ(near, expected_near);
  }
}

Points random_points(std::mt19937& random, int count, double half_width) {
  std::uniform_real_distribution<double> uniform(-half_width, half_width);
  Points points;
  for (int i = 0; i < count; ++i) points.emplace_back(uniform(random), uniform(random), uniform(random));
  return points;
}

// A cube of 12^3 points half a metre apart, in shuffled order: all coordinates and distances are exact in
// binary.
Points shuffled_lattice(std::mt19937& random) {
  Points points;
  for (int i = 0; i < 1728; ++i) points.emplace_back(0.5 * (i % 12), 0.5 * (i / 12 % 12), 0.5 * (i / 144));
  std::shuffle(points.begin(), points.end(), random);
  return points;
}

TEST(NearestNeighbours, AgreesWithExhaustiveSearchOnRandomPoints) {
  for (unsigned seed = 0; seed < 5; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937 random(seed);
    const Points points = random_points(random, 700, 10);
    expect_same_as_exhaustive(points, random_points(random, 200, 12), 2.5);
  }
}

// Midpoints of edges, faces and cells of the lattice have 2, 4 and 8 nearest points at exactly the same
// distance; its own points have 6 second ones.
TEST(NearestNeighbours, TiesGoToTheLowestIndexOnALattice) {
  for (unsigned seed = 0; seed < 3; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937 random(seed);
    const Points points = shuffled_lattice(random);
    Points queries;
    std::uniform_int_distribution<int> quarter(0, 22);
    for (int i = 0; i < 300; ++i) {
      queries.emplace_back(0.25 * quarter(random), 0.25 * quarter(random), 0.25 * quarter(random));
    }
    expect_same_as_exhaustive(points, queries, 0.5);
  }
}

TEST(NearestNeighbours, TiesGoToTheLowestIndexAmongDuplicates) {
  std::mt19937 random(7);
  Points points = random_points(random, 60, 1);
  for (int copies = 0; copies < 4; ++copies) points.insert(points.end(), points.begin(), points.begin() + 60);
  std::shuffle(points.begin(), points.end(), random);
  Points queries = random_points(random, 100, 1);
  queries.insert(queries.end(), points.begin(), points.begin() + 100);
  expect_same_as_exhaustive(points, queries, 0.4);
  expect_same_as_exhaustive(Points(500, Eigen::Vector3d(1, 2, 3)), {{1, 2, 3}, {0, 0, 0}}, 1);
}

// All points lie at distance 1 of the origin up to rounding: the bounds used to prune may not lose the
// nearest.
TEST(NearestNeighbours, FindsTheNearestAmongPointsOnASphere) {
  std::mt19937 random(11);
  Points points = random_points(random, 2000, 1);
  for (Eigen::Vector3d& p : points) p.normalize();
  expect_same_as_exhaustive(points, {{0, 0, 0}, {1e-17, 0, 0}, {1e-9, -1e-9, 0}}, 1.5);
}

TEST(NearestNeighbours, RadiusIsInclusive) {
  const NearestNeighbours tree({{3, 0, 0}, {0, 0.5, 0}, {0, 0, -0.5}, {0, 0.5000001, 0}});
  std::vector<std::int32_t> near;
  tree.within({0, 0, 0}, 0.5, near);
  EXPECT_THAT(near, ElementsAre(1, 2));
  tree.within({3, 0, 0}, 0, near);
  EXPECT_THAT(near, ElementsAre(0));
}

TEST(NearestNeighbours, EmptySetHasNoNeighbours) {
  const NearestNeighbours tree(Points{});
  std::vector<std::int32_t> near = {1};
  EXPECT_EQ(tree.nearest({1, 2, 3}).index, -1);
  EXPECT_THAT(tree.nearest({1, 2, 3}, 5), IsEmpty());
  tree.within({1, 2, 3}, 10, near);
  EXPECT_THAT(near, IsEmpty());
}

TEST(NearestNeighbours, NonFinitePointsAndQueriesHaveNoNeighbours) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  std::mt19937 random(3);
  Points points = random_points(random, 300, 5);
  for (std::size_t i = 0; i < 300; i += 3)
    points[i][static_cast<Eigen::Index>(i % 2)] = i % 4 ? nan : infinity;
  const NearestNeighbours tree(points);
  std::vector<std::int32_t> near;
  for (const Eigen::Vector3d& q :
       {Eigen::Vector3d(nan, 0, 0), Eigen::Vector3d(nan, nan, nan), Eigen::Vector3d(0, infinity, 0)}) {
    EXPECT_EQ(tree.nearest(q).index, -1);
    EXPECT_THAT(tree.nearest(q, 3), IsEmpty());
    tree.within(q, 1, near);
    EXPECT_THAT(near, IsEmpty());
  }
  EXPECT_EQ(tree.nearest(points[100]).index, 100);
  EXPECT_EQ(tree.nearest(points[100], 1000).size(), 200u);
}

TEST(NearestNeighbours, RefusesNegativeNumbersAndRadii) {
  const NearestNeighbours neighbours({{0, 0, 0}});
  std::vector<std::int32_t> out;
  EXPECT_TRUE(neighbours.nearest({0, 0, 0}, 0).empty());
  EXPECT_THROW((void)neighbours.nearest({0, 0, 0}, -1), ParameterError);
  EXPECT_THROW(neighbours.within({0, 0, 0}, -1, out), ParameterError);
  EXPECT_THROW(neighbours.within({0, 0, 0}, std::nan(""), out), ParameterError);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
