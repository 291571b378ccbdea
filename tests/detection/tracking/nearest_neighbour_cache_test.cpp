#include "detection/tracking/nearest_neighbour_cache.hpp"

#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace mapless {
namespace MAPLESS_FILE {

using Eigen::Vector3d;

// By exhaustive search.
std::size_t nearest(const std::vector<Vector3d>& points, const Vector3d& p) {
  std::size_t best = 0;
  for (std::size_t i = 1; i < points.size(); ++i) {
    if ((points[i] - p).squaredNorm() < (points[best] - p).squaredNorm()) best = i;
  }
  return best;
}

class Walk {
 public:
  explicit Walk(unsigned seed) : random_(seed) {}

  // On a coarse grid, so that many distances are equal.
  std::vector<Vector3d> random_points(std::size_t count) {
    std::vector<Vector3d> out(count);
    for (Vector3d& p : out) p = Vector3d(grid(), 3 * grid(), grid());
    return out;
  }
  void move(std::vector<Vector3d>& points, double most_m) {
    std::uniform_real_distribution<double> step(-most_m, most_m);
    for (Vector3d& p : points) p += Vector3d(step(random_), step(random_), step(random_));
  }

 private:
  double grid() { return std::uniform_int_distribution<int>(-4, 4)(random_); }
  std::mt19937 random_;
};

TEST(NearestNeighbourCache, AgreesWithExhaustiveSearchForAnyStep) {
  NearestNeighbourCache cache;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(seed);
    Walk walk(seed);
    std::vector<Vector3d> points = walk.random_points(5 * seed), queries = walk.random_points(40);
    cache.reset(queries.size());
    for (const double step_m : {0.0, 0.0, 1.0, 0.3, 0.1, 0.03, 0.01, 0.001, 0.5, 0.2, 0.2, 0.2}) {
      walk.move(points, step_m);
      walk.move(queries, step_m);
      cache.update_points(points);
      for (std::size_t i = 0; i < queries.size(); ++i) {
        cache.update_query(i, queries[i]);
        const std::size_t expected = nearest(points, queries[i]);
        EXPECT_EQ(cache.nearest(i).index, expected);
        EXPECT_EQ(cache.nearest(i).square, (points[expected] - queries[i]).squaredNorm());
      }
    }
  }
}

// The query is fixed; the farther of two points moves past the nearer one.
TEST(NearestNeighbourCache, NoticesWhenOnlyPointsMove) {
  NearestNeighbourCache cache;
  cache.reset(1);
  for (double x = 2; x > 0.5; x -= 0.05) {
    cache.update_points(std::vector<Vector3d>{{1, 0, 0}, {x, 0, 0}});
    cache.update_query(0, Vector3d::Zero());
    if (std::abs(x - 1) < 0.01) continue;  // equal distances
    EXPECT_EQ(cache.nearest(0).index, x < 1 ? 1u : 0u) << x;
  }
}

TEST(NearestNeighbourCache, IsInfinitelyFarFromNoPoints) {
  NearestNeighbourCache cache;
  cache.reset(1);
  cache.update_points({});
  cache.update_query(0, {1, 2, 3});
  EXPECT_TRUE(std::isinf(cache.nearest(0).square));
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
