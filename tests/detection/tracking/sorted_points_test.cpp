#include "detection/tracking/sorted_points.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace mapless {
namespace MAPLESS_FILE {

using Eigen::Vector3d;

TEST(SortedPoints, AgreesWithExhaustiveSearch) {
  SortedPoints sorted;  // reused over the seeds
  for (unsigned seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    std::uniform_int_distribution<int> place(-5, 5);  // a coarse grid, so that many distances are equal
    const auto point = [&] { return Vector3d(place(random), 3 * place(random), place(random)); };
    std::vector<Vector3d> points;
    for (unsigned i = 0; i < 4 * seed; ++i) points.push_back(point());
    sorted.assign(points);
    for (int k = 0; k < 50; ++k) {
      const Vector3d p = point() + Vector3d(0.5, 0, 0.25);
      std::size_t best = 0;
      for (std::size_t i = 1; i < points.size(); ++i) {
        if ((points[i] - p).squaredNorm() < (points[best] - p).squaredNorm()) best = i;
      }
      double second = std::numeric_limits<double>::infinity();
      for (std::size_t i = 0; i < points.size(); ++i) {
        if (i != best) second = std::min(second, (points[i] - p).squaredNorm());
      }
      const SortedPoints::Nearest found = sorted.nearest(p);
      EXPECT_EQ(found.index, best);
      EXPECT_EQ(found.square, (points[best] - p).squaredNorm());
      EXPECT_EQ(found.second_square, second);
    }
  }
}

TEST(SortedPoints, IsInfinitelyFarFromNoPoints) {
  SortedPoints sorted;
  EXPECT_TRUE(std::isinf(sorted.nearest({1, 2, 3}).square));
  sorted.assign(std::vector<Vector3d>{{1, 2, 3}});
  EXPECT_TRUE(std::isinf(sorted.nearest({1, 2, 3}).second_square));
  sorted.assign({});
  EXPECT_TRUE(std::isinf(sorted.nearest({1, 2, 3}).square));
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
