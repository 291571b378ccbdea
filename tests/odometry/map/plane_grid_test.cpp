#include "odometry/map/plane_grid.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "odometry/map/plane_map.hpp"
#include "oracle/plane_oracle.hpp"

namespace mapless {
namespace MAPLESS_FILE {

using Eigen::Vector3d;

constexpr double kSigma = 0.02;
unsigned next_laser = 0;  // every point of one of its own

struct Patch {
  Vector3d centre, u, v, normal;
};

Patch random_patch(std::mt19937& generator, const Vector3d& centre) {
  std::normal_distribution<double> normal;
  const Vector3d n = Vector3d(normal(generator), normal(generator), normal(generator)).normalized();
  const Vector3d u = n.unitOrthogonal();
  return {centre, u, n.cross(u), n};
}

std::vector<Vector3d> points_on(const Patch& patch, int count, double half_m, std::mt19937& generator) {
  std::uniform_real_distribution<double> uniform(-half_m, half_m);
  std::normal_distribution<double> noise(0, kSigma);
  std::vector<Vector3d> out;
  for (int i = 0; i < count; ++i)
    out.emplace_back(patch.centre + uniform(generator) * patch.u + uniform(generator) * patch.v +
                     noise(generator) * patch.normal);
  return out;
}

// A plane is fitted again when its cube has grown by a quarter: numbers of points at which the last fit has
// all.
int next_fit(int count) {
  int fitted = kMinPlanePoints;
  while (fitted < count) fitted = static_cast<int>(std::ceil(1.25 * fitted));
  return fitted;
}

bool insert(PlaneGrid& grid, const Vector3d& p, unsigned laser) {
  std::vector<unsigned> taken = {0};
  const std::vector<MapPoint> points = {{p, laser, 1}};
  grid.insert(points, 10, 1, taken);
  return taken[0] != 0;
}

// Lines of one laser, from a sensor that approaches a wall: a motion that is 5 % too short tilts the surface
// that they span.
TEST(PlaneGrid, HasNoPlaneOfOneLaserAlone) {
  PlaneGrid one({1, 0}, kSigma), two({1, 0}, kSigma);
  for (unsigned scan = 0; scan < 10; ++scan) {
    for (double y = 0.1; y < 1; y += 0.1) {
      const Vector3d p(0.4 + 0.02 * scan, y, 0.4 + 0.04 * scan);
      (void)insert(one, p, 7);
      (void)insert(two, p, 7 + scan % 2);
    }
  }
  EXPECT_FALSE(one.plane_at({0.5, 0.5, 0.5}));
  EXPECT_TRUE(two.plane_at({0.5, 0.5, 0.5}));
}

// Points of two lasers with noise of `noise_m` about a patch, every other point of the second laser and of
// scan number `second_scan`; the first is of scan 0.
PlaneGrid grid_of_two_lasers(std::vector<Vector3d> points, const Vector3d& normal, double noise_m,
                             unsigned second_scan) {
  std::vector<MapPoint> all;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double sign = i % 4 < 2 ? 1 : -1;
    all.push_back(
        {points[i] + sign * noise_m * normal, i % 2 == 0 ? 3u : 4u, 1, 0, i % 2 == 0 ? 0 : second_scan});
  }
  PlaneGrid grid({1, 0}, kSigma);
  std::vector<unsigned> taken(all.size(), 0);
  grid.insert(all, 10, 1, taken);
  return grid;
}

// How the lines of different scans lie to each other is as uncertain as the motion between the scans, 0.05 m;
// the lines of one scan are as certain as their noise.
TEST(PlaneGrid, LinesOfDifferentScansMakeALessCertainPlane) {
  std::vector<Vector3d> points;
  for (double x = 0.1; x < 0.95; x += 0.1)
    for (double y = 0.1; y < 0.95; y += 0.1) points.emplace_back(x, y, 0.5);
  const Vector3d q(0.6, 0.4, 0.5), up = Vector3d::UnitZ();
  const auto one_scan = grid_of_two_lasers(points, up, kSigma, 0).plane_at(q);
  const auto two_scans = grid_of_two_lasers(points, up, kSigma, 1).plane_at(q);
  ASSERT_TRUE(one_scan && two_scans);
  EXPECT_EQ(two_scans->normal_0, one_scan->normal_0);
  EXPECT_NEAR(one_scan->variance, kSigma * kSigma, 0.1 * kSigma * kSigma);
  EXPECT_NEAR(two_scans->variance - one_scan->variance, 0.05 * 0.05, 1e-6);
}

// In foliage, twice as rough as the noise, lines of different scans make a plane of whatever motion drew
// them.
TEST(PlaneGrid, RoughLinesOfDifferentScansMakeNoPlane) {
  std::vector<Vector3d> points;
  for (double x = 0.1; x < 0.95; x += 0.1)
    for (double y = 0.1; y < 0.95; y += 0.1) points.emplace_back(x, y, 0.5);
  const Vector3d q(0.6, 0.4, 0.5), up = Vector3d::UnitZ();
  EXPECT_TRUE(grid_of_two_lasers(points, up, 2 * kSigma, 0).plane_at(q));
  EXPECT_FALSE(grid_of_two_lasers(points, up, 2 * kSigma, 1).plane_at(q));
}

// Lines of a wall, one laser of each scan in the cube, and then a scan that hits it with two.
TEST(PlaneGrid, APlaneIsCertainOnceAScanHasHitItWithTwoLasers) {
  PlaneGrid grid({1, 0}, kSigma);
  const auto scan = [&](unsigned number, std::vector<unsigned> lasers) {
    std::vector<MapPoint> points;
    for (const unsigned laser : lasers)
      for (double x = 0.1; x < 0.95; x += 0.1)
        points.push_back({{x, 0.1 * laser, 0.5 + (laser % 2 == 0 ? kSigma : -kSigma)}, laser, 1, 0, number});
    std::vector<unsigned> taken(points.size(), 0);
    grid.insert(points, 10, 1, taken);
  };
  for (unsigned number = 1; number <= 8; ++number) scan(number, {number});
  ASSERT_TRUE(grid.plane_at({0.5, 0.5, 0.5}));
  EXPECT_GT(grid.plane_at({0.5, 0.5, 0.5})->variance, 0.05 * 0.05);
  scan(9, {4});
  scan(10, {5, 6});
  EXPECT_LT(grid.plane_at({0.5, 0.5, 0.5})->variance, 1.2 * kSigma * kSigma);
}

TEST(PlaneGrid, GivesTheLeastSquaresPlaneOfTheCube) {
  for (unsigned seed = 1; seed <= 50; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 generator(seed);
    // Also far from the origin: 30 km away the resolution of a float is 2 mm.
    const Vector3d centre = seed % 2 == 0 ? Vector3d(0.5, 0.5, 0.5) : Vector3d(30000.5, -19999.5, 5.5);
    const Patch patch = random_patch(generator, centre);
    const auto points = points_on(patch, next_fit(6 + static_cast<int>(seed)), 0.2, generator);
    PlaneGrid grid({1, 0}, kSigma);
    for (const Vector3d& p : points) ASSERT_TRUE(insert(grid, p, next_laser++));
    const Vector3d q = centre + 0.1 * patch.u - 0.15 * patch.v + 0.05 * patch.normal;
    const auto plane = grid.plane_at(q);
    ASSERT_TRUE(plane);
    const auto expected = test::plane_through(points);
    EXPECT_NEAR(std::abs(plane->normal_0.dot(expected.normal)), 1, 1e-5);
    EXPECT_NEAR((plane->point_0 - expected.mean).norm(), 0, 1e-6);
    const double variance = test::variance_at(expected, points.size(), kSigma * kSigma, 6, q);
    EXPECT_NEAR(plane->variance, variance, 1e-3 * variance);
  }
}

// The points of a scan in random order: in adjacent cubes, and some beyond the maximum range.
void expect_many_at_once_as_one_by_one(bool shuffled) {
  std::mt19937 generator(5);
  std::vector<MapPoint> points;
  for (int i = 0; i < 12; ++i) {
    const Patch patch = random_patch(generator, {0.5 + i % 4, 0.5 + i / 4, 0.5});
    for (const Vector3d& p : points_on(patch, next_fit(20 + i), 0.2, generator))
      points.push_back({p, next_laser++, 1});
  }
  if (shuffled) std::shuffle(points.begin(), points.end(), generator);
  for (std::size_t i = 0; i < points.size(); i += 40)
    points.insert(points.begin() + static_cast<std::ptrdiff_t>(i), {{500, 0, 0}, next_laser++, 11});
  PlaneGrid together({1, 0}, kSigma), one_by_one({1, 0}, kSigma);
  std::vector<unsigned> taken(points.size(), 4);
  together.insert(points, 10, 1, taken);
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_EQ(taken[i], points[i].range_m > 10 ? 4u : 5u);
    if (points[i].range_m < 10) (void)insert(one_by_one, points[i].p_0, points[i].laser);
  }
  EXPECT_EQ(together.cubes(), 12u);
  for (int i = 0; i < 12; ++i) {
    const auto plane = together.plane_at({0.5 + i % 4, 0.5 + i / 4, 0.5});
    const auto expected = one_by_one.plane_at({0.5 + i % 4, 0.5 + i / 4, 0.5});
    ASSERT_TRUE(plane && expected);
    EXPECT_NEAR(std::abs(plane->normal_0.dot(expected->normal_0)), 1, 1e-6);
    EXPECT_NEAR((plane->point_0 - expected->point_0).norm(), 0, 1e-6);
  }
}

TEST(PlaneGrid, InsertingManyPointsEqualsInsertingOneByOne) {
  for (const bool shuffled : {false, true}) {
    SCOPED_TRACE(shuffled);
    expect_many_at_once_as_one_by_one(shuffled);
  }
}

// 480 points in runs that leave the cube and return, as the firings of a laser do beside an edge. The cube
// accepts those of the lowest passes, and the first ones of the last of these passes.
TEST(PlaneGrid, ACubeWithoutRoomForAllAcceptsTheLowestPasses) {
  for (const int before : {0, 100}) {
    SCOPED_TRACE(before);
    PlaneGrid grid({1, 0}, kSigma);
    for (int i = 0; i < before; ++i) ASSERT_TRUE(insert(grid, {0.5, 0.5, 0.5}, next_laser++));
    std::vector<MapPoint> points;
    for (unsigned i = 0; i < 480; ++i) {
      points.push_back({{0.5, 0.5, 0.002 * i + 0.01}, next_laser++, 1, i % 9});
      if (i % 7 == 0) points.push_back({{1.5, 0.5 + i, 0.5}, next_laser++, 1, i % 9});
    }
    std::vector<unsigned> taken(points.size(), 0);
    grid.insert(points, 10, 1, taken);
    int room = PlaneGrid::kMaxPoints - before;
    for (unsigned pass = 0; pass < 9; ++pass) {
      for (std::size_t i = 0; i < points.size(); ++i) {
        if (points[i].pass != pass) continue;
        const bool beside = points[i].p_0.x() > 1;
        EXPECT_EQ(taken[i] != 0, beside || room > 0) << i;
        if (!beside) --room;
      }
    }
    EXPECT_FALSE(insert(grid, {0.5, 0.5, 0.5}, next_laser++));
  }
}

TEST(PlaneGrid, RemovedPointsLeaveNoTrace) {
  std::mt19937 generator(4);
  const Patch patch = random_patch(generator, {2.5, 0.5, 0.5});
  const auto points = points_on(patch, next_fit(30), 0.2, generator);
  const auto others = points_on(random_patch(generator, {2.5, 0.5, 0.5}), 20, 0.3, generator);
  PlaneGrid plain({1, 0}, kSigma), changed({1, 0}, kSigma);
  for (const Vector3d& p : points) (void)insert(plain, p, next_laser++);
  for (const Vector3d& p : others) (void)insert(changed, p, next_laser++);
  for (const Vector3d& p : points) (void)insert(changed, p, next_laser++);
  changed.remove(others);
  const auto expected = plain.plane_at(patch.centre);
  const auto found = changed.plane_at(patch.centre);
  ASSERT_TRUE(expected && found);
  EXPECT_NEAR(std::abs(found->normal_0.dot(expected->normal_0)), 1, 1e-6);
  EXPECT_NEAR(found->variance, expected->variance, 1e-6 * expected->variance);
  changed.remove(points);
  EXPECT_FALSE(changed.plane_at(patch.centre));
  changed.remove({points[0], {500, 0, 0}});
  EXPECT_FALSE(changed.plane_at(patch.centre));
}

TEST(PlaneGrid, HasNoPlaneOfFewPointsALineOrACloud) {
  PlaneGrid few({1, 0}, kSigma), line({1, 0}, kSigma), cloud({1, 0}, kSigma);
  std::mt19937 generator(8);
  std::uniform_real_distribution<double> uniform(0.1, 0.9);
  for (int i = 0; i + 1 < kMinPlanePoints; ++i)
    (void)insert(few, {0.15 * i + 0.05, 0.3 * (i % 3) + 0.1, 0.5}, next_laser++);
  for (int i = 0; i < 60; ++i) {
    (void)insert(line, {uniform(generator), 0.5, 0.5}, next_laser++);
    (void)insert(cloud, {uniform(generator), uniform(generator), uniform(generator)}, next_laser++);
  }
  for (const PlaneGrid* grid : {&few, &line, &cloud}) EXPECT_FALSE(grid->plane_at({0.5, 0.5, 0.5}));
}

// A floor on the face between two cubes: each has the points of half of its noise, neither has the surface.
TEST(PlaneGrid, HasNoPlaneThatAFaceOfTheCubeCuts) {
  std::mt19937 generator(9);
  const Patch floor = {{0.5, 0.5, 1}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  PlaneGrid cut({1, 0}, kSigma), shifted({1, 0.4}, kSigma);
  for (const Vector3d& p : points_on(floor, 200, 0.4, generator)) {
    (void)insert(cut, p, next_laser++);
    (void)insert(shifted, p, next_laser++);
  }
  EXPECT_FALSE(cut.plane_at({0.5, 0.5, 1.01}));
  EXPECT_FALSE(cut.plane_at({0.5, 0.5, 0.99}));
  EXPECT_TRUE(shifted.plane_at({0.5, 0.5, 0.99}));
}

TEST(PlaneGrid, CubesAtTheOriginAreAsWideAsOthers) {
  PlaneGrid grid({1, 0}, kSigma);
  for (const double x : {-0.5, 0.5, 1.5}) (void)insert(grid, {x, 0.5, 0.5}, next_laser++);
  EXPECT_EQ(grid.cubes(), 3u);
}

TEST(PlaneGrid, AFullCubeAcceptsNoMore) {
  PlaneGrid grid({1, 0}, kSigma);
  for (int i = 0; i < PlaneGrid::kMaxPoints; ++i) EXPECT_TRUE(insert(grid, {0.5, 0.5, 0.5}, next_laser++));
  EXPECT_FALSE(insert(grid, {0.5, 0.5, 0.5}, next_laser++));
  grid.remove({{0.5, 0.5, 0.5}});
  EXPECT_TRUE(insert(grid, {0.5, 0.5, 0.5}, next_laser++));
  EXPECT_FALSE(insert(grid, {0.5, 0.5, 0.5}, next_laser++));
}

// Cleared, a grid keeps its memory but none of its points: neither planes, nor cubes that are full, nor
// lasers.
TEST(PlaneGrid, AClearedGridIsAsANewOne) {
  PlaneGrid grid({1, 0}, kSigma);
  for (int x = 0; x < 5000; ++x) (void)insert(grid, {x + 0.5, 0.5, 0.5}, next_laser++);
  for (int i = 0; i < 200; ++i)
    (void)insert(grid, {0.02 * (i % 40) + 0.1, 0.05 * (i % 16) + 0.1, 0.5}, next_laser++);
  ASSERT_TRUE(grid.plane_at({0.5, 0.5, 0.5}));
  grid.clear();
  EXPECT_EQ(grid.cubes(), 0u);
  EXPECT_FALSE(grid.plane_at({0.5, 0.5, 0.5}));
  for (int i = 0; i < 10; ++i) EXPECT_TRUE(insert(grid, {0.1 * i + 0.05, 0.1 * (i * 3 % 10) + 0.05, 0.5}, 1));
  EXPECT_FALSE(grid.plane_at({0.5, 0.5, 0.5})) << "of one laser";
  EXPECT_TRUE(insert(grid, {0.5, 0.1, 0.5}, 2) && insert(grid, {0.1, 0.6, 0.5}, 2) &&
              insert(grid, {0.8, 0.6, 0.5}, 2));
  const auto plane = grid.plane_at({0.5, 0.5, 0.5});
  ASSERT_TRUE(plane);
  EXPECT_NEAR(std::abs(plane->normal_0.z()), 1, 1e-6);
}

TEST(PlaneGrid, RemovesCubesThatAreFar) {
  PlaneGrid grid({1, 0}, kSigma);
  for (int x = 0; x < 3000; ++x) (void)insert(grid, {x + 0.5, 0.5, 0.5}, next_laser++);
  grid.keep_within({1000, 0, 0}, 100);
  EXPECT_EQ(grid.cubes(), 201u);
  (void)insert(grid, {1000.9, 0.5, 0.5}, next_laser++);
  EXPECT_EQ(grid.cubes(), 201u) << "the table still finds the others";
  for (int x = -3000; x < 0; ++x) (void)insert(grid, {x + 0.5, -0.5, 0.5}, next_laser++);
  grid.keep_within({-1000, 0, 0}, 100);
  EXPECT_EQ(grid.cubes(), 199u) << "on the negative side, whose corners are 1 m farther";
}

TEST(PlaneGrid, IgnoresPointsWithoutACube) {
  PlaneGrid grid({1, 0}, kSigma);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(insert(grid, {nan, 0, 0}, next_laser++));
  EXPECT_FALSE(insert(grid, {0, 1e300, 0}, next_laser++));
  EXPECT_FALSE(insert(grid, {0, 0, -std::numeric_limits<double>::infinity()}, next_laser++));
  EXPECT_EQ(grid.cubes(), 0u);
  EXPECT_FALSE(grid.plane_at({nan, 0, 0}));
}

std::optional<MapPlane> plane_near(const PlaneMap& map, const Vector3d& p_0) {
  CachedPlane found;
  map.find_planes({&p_0, 1}, {&found, 1});
  return found.plane;
}

TEST(PlaneMap, ACachedPlaneEqualsTheOneFoundAgain) {
  std::mt19937 generator(12);
  std::uniform_real_distribution<double> uniform(-1, 1);
  PlaneMap map(kSigma);
  std::vector<Vector3d> queries;
  for (int i = 0; i < 40; ++i) {
    const Patch patch = random_patch(generator, 6 * Vector3d(uniform(generator), uniform(generator), 0.1));
    for (const Vector3d& p : points_on(patch, 300, 1, generator))
      (void)map.insert(std::vector<MapPoint>{{p, next_laser++, 10}});
    for (const Vector3d& p : points_on(patch, 30, 1, generator)) queries.push_back(p);
  }
  std::vector<CachedPlane> kept(queries.size());
  map.find_planes(queries, kept);
  int still_valid = 0, planes = 0;
  for (std::size_t i = 0; i < queries.size(); ++i) {
    SCOPED_TRACE(i);
    const CachedPlane before = kept[i];
    const Vector3d moved =
        queries[i] + 0.003 * Vector3d(uniform(generator), uniform(generator), uniform(generator));
    map.find_planes({&moved, 1}, {&kept[i], 1});
    const auto anew = plane_near(map, moved);
    ASSERT_EQ(kept[i].plane.has_value(), anew.has_value());
    EXPECT_EQ(kept[i].query_0, before.valid_at(moved) ? queries[i] : moved);
    still_valid += before.valid_at(moved) ? 1 : 0;
    if (!anew) continue;
    ++planes;
    EXPECT_EQ(kept[i].plane->point_0, anew->point_0);
    EXPECT_EQ(kept[i].plane->normal_0, anew->normal_0);
    EXPECT_NEAR(kept[i].plane->variance, anew->variance, 0.03 * anew->variance);
  }
  EXPECT_GT(still_valid, 1000);
  EXPECT_LT(still_valid, 1200) << "some points enter another cube";
  EXPECT_GT(planes, 600);
}

TEST(PlaneMap, AFarSparseWallHasACoarsePlaneAndANearOneAFinePlane) {
  std::mt19937 generator(10);
  PlaneMap map(kSigma);
  const Patch wall = {{41.8, 1.8, 1.8}, {0, 1, 0}, {0, 0, 1}, {1, 0, 0}};
  for (const Vector3d& p : points_on(wall, 8, 0.8, generator))
    EXPECT_EQ(map.insert(std::vector<MapPoint>{{p, next_laser++, 90}}), std::vector{12u});
  EXPECT_TRUE(plane_near(map, wall.centre));
  for (const Vector3d& p : points_on(wall, 60, 0.8, generator))
    EXPECT_EQ(map.insert(std::vector<MapPoint>{{p, next_laser++, 10}}), std::vector{15u});
  const auto plane = plane_near(map, wall.centre);
  ASSERT_TRUE(plane);
  EXPECT_LT(plane->variance, 2.25 * kSigma * kSigma);
  EXPECT_NEAR(std::abs(plane->normal_0.x()), 1, 0.01);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
