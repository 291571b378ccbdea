#include "detection/tracking/nearest_neighbour_cache.hpp"

#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace mapless {
namespace MAPLESS_FILE {

using Eigen::Vector3d;

// By trying all.
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

  // A coarse grid: many as near as each other.
  std::vector<Vector3d> places(std::size_t count) {
    std::vector<Vector3d> out(count);
    for (Vector3d& p : out) p = Vector3d(grid(), 3 * grid(), grid());
    return out;
  }
  void move(std::vector<Vector3d>& places, double most_m) {
    std::uniform_real_distribution<double> step(-most_m, most_m);
    for (Vector3d& p : places) p += Vector3d(step(random_), step(random_), step(random_));
  }

 private:
  double grid() { return std::uniform_int_distribution<int>(-4, 4)(random_); }
  std::mt19937 random_;
};

TEST(NearestNeighbourCache, AreThoseThatTryingAllFindsHoweverFarThingsMove) {
  NearestNeighbourCache neighbours;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(seed);
    Walk walk(seed);
    std::vector<Vector3d> points = walk.places(5 * seed), places = walk.places(40);
    neighbours.restart(places.size());
    for (const double step_m : {0.0, 0.0, 1.0, 0.3, 0.1, 0.03, 0.01, 0.001, 0.5, 0.2, 0.2, 0.2}) {
      walk.move(points, step_m);
      walk.move(places, step_m);
      neighbours.move_points(points);
      for (std::size_t i = 0; i < places.size(); ++i) {
        neighbours.move_place(i, places[i]);
        const std::size_t expected = nearest(points, places[i]);
        EXPECT_EQ(neighbours.of(i).index, expected);
        EXPECT_EQ(neighbours.of(i).square, (points[expected] - places[i]).squaredNorm());
      }
    }
  }
}

// The place stands; of two points the one behind comes past the one that was nearest.
TEST(NearestNeighbourCache, ChangeWhenPointsAloneMove) {
  NearestNeighbourCache neighbours;
  neighbours.restart(1);
  for (double x = 2; x > 0.5; x -= 0.05) {
    neighbours.move_points(std::vector<Vector3d>{{1, 0, 0}, {x, 0, 0}});
    neighbours.move_place(0, Vector3d::Zero());
    if (std::abs(x - 1) < 0.01) continue;  // as near as each other
    EXPECT_EQ(neighbours.of(0).index, x < 1 ? 1u : 0u) << x;
  }
}

TEST(NearestNeighbourCache, NothingIsNearToNoPoints) {
  NearestNeighbourCache neighbours;
  neighbours.restart(1);
  neighbours.move_points({});
  neighbours.move_place(0, {1, 2, 3});
  EXPECT_TRUE(std::isinf(neighbours.of(0).square));
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
