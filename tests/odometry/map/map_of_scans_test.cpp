#include "odometry/map/map_of_scans.hpp"

#include <random>

#include <gtest/gtest.h>

namespace mapless {
namespace MAPLESS_FILE {

using Eigen::Vector3d;

constexpr double kSigma = 0.02;

// A near wall has a plane in a fine grid, a far one in a coarse grid, as in PlaneMap.
TEST(MapOfScans, HasThePlanesOfAPlaneMapOfTheOthers) {
  std::mt19937 generator(4);
  std::uniform_real_distribution<double> uniform(0, 8);
  std::normal_distribution<double> normal(0, kSigma);
  std::vector<std::vector<MapPoint>> scans(2);
  for (unsigned s = 0; s < 2; ++s) {
    for (int i = 0; i < 2000; ++i)
      scans[s].push_back(
          {{20 + normal(generator), uniform(generator), uniform(generator)}, i % 9u, 20, 0, s});
    for (int i = 0; i < 100; ++i)
      scans[s].push_back(
          {{90 + normal(generator), uniform(generator), uniform(generator)}, i % 9u, 90, 0, s});
  }
  MapOfScans map(kSigma);
  map.assign(scans);
  PlaneMap other(kSigma);
  (void)other.insert(scans[1]);
  std::vector<Vector3d> queries;
  for (double y = 1; y < 7; y += 0.37)
    for (const double x : {20., 90.}) queries.emplace_back(x, y, 8 - y);
  std::vector<CachedPlane> found(queries.size()), expected(queries.size());
  map.without(0).find_planes(queries, found);
  other.find_planes(queries, expected);
  int planes = 0;
  for (std::size_t i = 0; i < queries.size(); ++i) {
    ASSERT_EQ(found[i].plane.has_value(), expected[i].plane.has_value()) << queries[i].transpose();
    EXPECT_EQ(found[i].valid_within_m, expected[i].valid_within_m);
    if (!found[i].plane) continue;
    ++planes;
    // PlaneMap fits a plane again only once its cube has grown by a quarter.
    EXPECT_NEAR((found[i].plane->point_0 - expected[i].plane->point_0).norm(), 0, 0.3);
    EXPECT_NEAR(std::abs(found[i].plane->normal_0.x()), 1, 0.02);
  }
  EXPECT_GT(planes, 25);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
