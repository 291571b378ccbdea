#include "detection/published/region_growth.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <utility>

#include <gtest/gtest.h>

#include "geometry/nearest_neighbours.hpp"
#include "oracle/clustering_oracle.hpp"

namespace mapless {
namespace MAPLESS_FILE {

using Eigen::Vector3d;
using test::OraclePoint;
using Points = std::vector<OraclePoint>;

PreparedScan prepared(const Points& points) {
  auto scan = std::make_shared<LidarScan>();
  scan->model = std::make_shared<const LidarModel>();
  CompensatedScan compensated;
  std::vector<Eigen::Vector3f> normals;
  for (const OraclePoint& p : points) {
    LidarReturn r{};
    r.position_v.setZero();
    r.range_m = static_cast<float>(p.range_m);
    r.input_index = static_cast<std::uint32_t>(scan->returns.size());
    scan->returns.push_back(r);
    compensated.points_0.push_back(p.position_0);
    normals.push_back(p.normal_0);
  }
  compensated.scan = scan;
  NearestNeighbours neighbours(compensated.points_0);
  return {std::move(compensated), std::move(neighbours), std::move(normals)};
}

RegionGrowthResult grow(const Points& points, const RegionGrowthParameters& parameters) {
  std::vector<char> dynamic;
  for (const OraclePoint& p : points) dynamic.push_back(p.dynamic ? 1 : 0);
  return grow_regions(prepared(points), dynamic, parameters);
}

int in_objects(const RegionGrowthResult& result) {
  return static_cast<int>(
      std::count_if(result.object.begin(), result.object.end(), [](auto o) { return o != 0; }));
}

/// The number of points that growth reached.
int expect_agreement(const Points& points, const RegionGrowthParameters& parameters) {
  const RegionGrowthResult result = grow(points, parameters);
  const test::OracleObjects expected = test::objects_by_pairs(points, parameters);
  EXPECT_EQ(result.objects, expected.objects);
  EXPECT_EQ(result.object, expected.object);
  EXPECT_EQ(result.verdict, expected.verdict);
  return static_cast<int>(std::count(result.verdict.begin(), result.verdict.end(), GrowthVerdict::grown));
}

/// A row of points along x, `step` apart, with one normal; the first `seeds` are dynamic.
Points row(double x, int count, double step, const Eigen::Vector3f& normal, int seeds) {
  Points points;
  for (int i = 0; i < count; ++i) points.push_back({{x + step * i, 0, 0}, normal, 10.0, i < seeds});
  return points;
}

RegionGrowthParameters plain_parameters() {
  RegionGrowthParameters p;
  p.link_m = 0.12;
  p.link_per_m = 0;
  p.min_cluster_points = 3;
  p.max_growth_m = 1;
  return p;
}

// Seeds at 0, 0.1 and 0.2 m on a plane: growth goes on to 1.2 m, a metre from the last seed.
TEST(RegionGrowth, SpreadsOverAPlaneUpToTheDistanceAllowed) {
  const Points points = row(0, 30, 0.1, {0, 0, 1}, 3);
  RegionGrowthParameters parameters = plain_parameters();
  parameters.max_growth_m = 1.05;
  const RegionGrowthResult result = grow(points, parameters);
  EXPECT_EQ(result.objects, 1);
  EXPECT_EQ(in_objects(result), 13);
  EXPECT_EQ(std::count(result.verdict.begin(), result.verdict.end(), GrowthVerdict::grown), 10);
}

TEST(RegionGrowth, StopsWhereNormalsEndOrTheLinkIsTooLong) {
  Points points = row(0, 10, 0.1, {0, 0, 1}, 3);
  points[6].normal_0.setZero();
  EXPECT_EQ(in_objects(grow(points, plain_parameters())), 6);
  points = row(0, 10, 0.1, {0, 0, 1}, 3);
  for (std::size_t i = 5; i < points.size(); ++i) points[i].position_0.x() += 0.03;
  EXPECT_EQ(in_objects(grow(points, plain_parameters())), 5);
}

// From a wall growth turns an outer corner, not an inner one: there each side rises above the other's plane.
TEST(RegionGrowth, TurnsConvexCornersOnly) {
  for (const bool convex : {true, false}) {
    Points points = row(0, 5, 0.1, {0, 0, 1}, 3);
    for (int i = 1; i <= 4; ++i) {
      const double z = (convex ? -0.1 : 0.1) * i;
      points.push_back(
          {{0.42, 0, z}, convex ? Eigen::Vector3f(1, 0, 0) : Eigen::Vector3f(-1, 0, 0), 10, false});
    }
    EXPECT_EQ(in_objects(grow(points, plain_parameters())), convex ? 9 : 5);
  }
}

// A step of 0.1 m up over 0.05 m: the upper points lie above the plane of the lower ones, so that growth
// passes only because the normals of both are parallel. Here the upper normals are tilted about the step's
// edge.
TEST(RegionGrowth, PassesConcaveStepsBetweenParallelSurfaces) {
  constexpr double kDegree = std::numbers::pi / 180;
  for (const auto& [tilt_deg, reached] : {std::pair{0.0, 10}, {9.9, 10}, {10.1, 5}, {-9.9, 10}, {-10.1, 5}}) {
    SCOPED_TRACE(testing::Message() << "normals " << tilt_deg << " degrees apart");
    Points points = row(0, 10, 0.05, {0, 0, 1}, 3);
    for (std::size_t i = 5; i < points.size(); ++i) {
      points[i].position_0.z() = 0.1;
      points[i].normal_0 = {0, static_cast<float>(std::sin(tilt_deg * kDegree)),
                            static_cast<float>(std::cos(tilt_deg * kDegree))};
    }
    RegionGrowthParameters parameters = plain_parameters();
    parameters.parallel_tolerance_deg = 10;
    EXPECT_EQ(in_objects(grow(points, parameters)), reached);
  }
}

TEST(RegionGrowth, DropsSmallClustersAndNumbersObjectsByTheirLowestPoint) {
  Points points = row(0, 2, 0.1, {0, 0, 1}, 2);
  for (const double x : {20.0, 10.0})
    for (const OraclePoint& p : row(x, 3, 0.1, {0, 0, 1}, 3)) points.push_back(p);
  const RegionGrowthResult result = grow(points, plain_parameters());
  EXPECT_EQ(result.object, (std::vector<std::uint16_t>{0, 0, 1, 1, 1, 2, 2, 2}));
  EXPECT_EQ(result.verdict[0], GrowthVerdict::too_small);
}

/// Patches of random size, place and orientation that overlap, meet at corners, or stand alone; some are
/// dynamic, most normals are there and roughly right.
Points random_patches(std::mt19937_64& random) {
  std::uniform_real_distribution<double> unit(-1, 1);
  const auto vector = [&] { return Vector3d(unit(random), unit(random), unit(random)); };
  Points points;
  const std::size_t patches = 3 + random() % 6;
  for (std::size_t k = 0; k < patches; ++k) {
    const Vector3d centre = 1.5 * vector();
    const Vector3d normal = vector().normalized();
    const double size = 0.2 + 0.8 * std::abs(unit(random));
    const double dynamic_share = random() % 2 == 0 ? 0.0 : 0.15;
    for (std::size_t i = 0; i < 60; ++i) {
      Vector3d p = size * vector();
      p += (0.02 * unit(random) - normal.dot(p)) * normal;
      Eigen::Vector3f n = (normal + 0.1 * vector()).normalized().cast<float>();
      if (random() % 10 == 0) n.setZero();
      points.push_back({centre + p, n, static_cast<double>(static_cast<float>(5 + 3 * unit(random))),
                        std::abs(unit(random)) < dynamic_share});
    }
  }
  std::shuffle(points.begin(), points.end(), random);
  return points;
}

TEST(RegionGrowth, AgreesWithUnionFindOverAllPairs) {
  int grown = 0;
  for (unsigned seed = 0; seed < 150; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937_64 random(seed);
    RegionGrowthParameters parameters;
    parameters.link_m = 0.05 + 0.05 * static_cast<double>(seed % 5);
    parameters.min_cluster_points = 1 + static_cast<int>(seed % 4);
    parameters.max_growth_m = 0.2 + 0.3 * static_cast<double>(seed % 3);
    parameters.concave_tolerance_deg = 5.0 * static_cast<double>(seed / 2 % 2);
    parameters.parallel_tolerance_deg = 10.0 * static_cast<double>(seed / 4 % 2);
    grown += expect_agreement(random_patches(random), parameters);
    if (HasFailure()) break;
  }
  EXPECT_GT(grown, 1000);
}

TEST(RegionGrowth, HasNothingToDoWithoutPointsOrWithoutSeeds) {
  EXPECT_EQ(grow({}, {}).objects, 0);
  const RegionGrowthResult result = grow(row(0, 5, 0.1, {0, 0, 1}, 0), {});
  EXPECT_EQ(result.objects, 0);
  EXPECT_EQ(result.verdict, std::vector<GrowthVerdict>(5, GrowthVerdict::not_reached));
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
