#include "detection/published/point_pool.hpp"

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace mapless {
namespace MAPLESS_FILE {

using Eigen::Vector3d;
using Indices = std::vector<std::int32_t>;

// Points of a 5 x 5 x 5 lattice of 0.25 m, several at one place: distances are exact, many are equal.
std::vector<Vector3d> lattice_points(std::mt19937_64& random, std::size_t count) {
  std::vector<Vector3d> points;
  const auto coordinate = [&] { return 0.25 * static_cast<double>(random() % 5); };
  for (std::size_t i = 0; i < count; ++i) points.emplace_back(coordinate(), coordinate(), coordinate());
  return points;
}

TEST(PointPool, FindsWhatIsLeftWithinARadius) {
  for (unsigned seed = 0; seed < 30; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937_64 random(seed);
    const std::vector<Vector3d> points = lattice_points(random, 1 + random() % 200);
    Indices left;
    for (std::size_t i = 0; i < points.size(); ++i)
      if (random() % 4 != 0) left.push_back(static_cast<std::int32_t>(i));
    PointPool pool(points, left);
    for (int query = 0; query < 40; ++query) {
      const Vector3d q = lattice_points(random, 1).front();
      const double radius_m = 0.25 * static_cast<double>(random() % 4);
      Indices expected, rest, found;
      for (const std::int32_t i : left) {
        const bool near = (points[static_cast<std::size_t>(i)] - q).norm() <= radius_m;
        if (near) expected.push_back(i);
        if (!near || i % 3 != 0) rest.push_back(i);
      }
      EXPECT_EQ(pool.any_within(q, radius_m), !expected.empty());
      pool.take_within(q, radius_m, [&](std::int32_t i) {
        found.push_back(i);
        return i % 3 == 0;
      });
      std::sort(found.begin(), found.end());
      ASSERT_EQ(found, expected);
      left = rest;
    }
  }
}

TEST(PointPool, IsEmptyWithoutPoints) {
  PointPool pool({}, {});
  EXPECT_FALSE(pool.any_within({0, 0, 0}, 1000));
  pool.take_within({0, 0, 0}, 1000, [](std::int32_t) {
    ADD_FAILURE() << "there is no point";
    return true;
  });
}

// Flooding visits a point once however many neighbours it has: of n points within one radius each search
// after the first finds none. The searches of a neighbourhood that does not shrink would find n x n.
TEST(PointPool, FloodingFindsEachPointOnce) {
  std::vector<Vector3d> points;
  for (int i = 0; i < 2000; ++i) points.emplace_back(1e-5 * i, 0, 0);
  Indices all(points.size());
  std::iota(all.begin(), all.end(), 0);
  PointPool pool(points, all);
  std::size_t found = 0;
  for (const Vector3d& p : points) {
    pool.take_within(p, 0.1, [&](std::int32_t) { return ++found, true; });
  }
  EXPECT_EQ(found, points.size());
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
