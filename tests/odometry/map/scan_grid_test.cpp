#include "odometry/map/scan_grid.hpp"

#include <random>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "odometry/map/plane_search.hpp"
#include "oracle/plane_oracle.hpp"

namespace mapless {
namespace MAPLESS_FILE {

using Eigen::Vector3d;

constexpr double kSigma = 0.02;
constexpr std::size_t kScans = 4;
constexpr std::size_t kNoScan = kScans;
const CubeLattice kLattice(1, 0);

// Rough patches in 20 adjacent cubes, some of them far from the sensor, as a few scans see them. Each scan
// sees most of them, with one to three lasers.
std::vector<std::vector<MapPoint>> random_scans(std::mt19937& generator) {
  std::uniform_real_distribution<double> uniform(0, 1);
  std::normal_distribution<double> normal(0, kSigma);
  std::vector<std::vector<MapPoint>> out(kScans);
  for (int cube = 0; cube < 20; ++cube) {
    const Vector3d tilt = Vector3d(uniform(generator), uniform(generator), 2).normalized();
    for (unsigned s = 0; s < kScans; ++s) {
      const auto lasers = static_cast<unsigned>(4 * uniform(generator));
      for (unsigned laser = 0; laser < lasers; ++laser) {
        for (int i = 0; i < 7; ++i) {
          const double x = 0.15 + 0.7 * uniform(generator), y = 0.2 + 0.2 * laser;
          const double z = 0.5 - (tilt.x() * (x - 0.5) + tilt.y() * (y - 0.5)) / tilt.z() + normal(generator);
          out[s].push_back({{cube % 5 + x, cube / 5 + y, z}, laser + s, cube == 7 ? 99. : 5., 0, s});
        }
      }
    }
  }
  return out;
}

CachedPlane plane_of(const ScanGrid::Others& grid, const Vector3d& q_0) {
  std::vector<CachedPlane> out(1);
  find_planes_in<ScanGrid::Others>(std::span(&grid, 1), kSigma * kSigma, std::span(&q_0, 1), out);
  return out.front();
}

std::vector<Vector3d> in_cube(const std::vector<std::vector<MapPoint>>& scans, std::size_t without,
                              const Vector3d& corner_0) {
  std::vector<Vector3d> out;
  for (std::size_t s = 0; s < scans.size(); ++s) {
    for (const MapPoint& point : scans[s]) {
      const Vector3d p = point.p_0 - corner_0;
      if (s != without && point.range_m < 10 && p.minCoeff() >= 0 && p.maxCoeff() < 1)
        out.push_back(point.p_0);
    }
  }
  return out;
}

// Against the same grid without the points of the scan, and against the least-squares plane of the others.
TEST(ScanGrid, HasThePlanesOfTheOtherScans) {
  int planes = 0, none = 0;
  for (unsigned seed = 1; seed <= 10; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 generator(seed);
    const auto scans = random_scans(generator);
    ScanGrid all(kLattice, kSigma);
    for (const auto& points : scans) all.add_scan(points, 10);
    for (std::size_t without = 0; without <= kScans; ++without) {
      ScanGrid others(kLattice, kSigma);
      for (std::size_t s = 0; s < kScans; ++s) {
        if (s != without) others.add_scan(scans[s], 10);
      }
      for (int cube = 0; cube < 20; ++cube) {
        const Vector3d corner_0(cube % 5, cube / 5, 0), q_0 = corner_0 + Vector3d(0.4, 0.6, 0.5);
        const auto plane = plane_of({all, without}, q_0).plane;
        const auto expected = plane_of({others, kNoScan}, q_0).plane;
        ASSERT_EQ(plane.has_value(), expected.has_value()) << "cube " << cube << " without " << without;
        if (!plane) {
          ++none;
          continue;
        }
        ++planes;
        EXPECT_NEAR(plane->variance, expected->variance, 1e-9);
        const auto oracle = test::plane_through(in_cube(scans, without, corner_0));
        EXPECT_NEAR((plane->point_0 - oracle.mean).norm(), 0, 1e-6);
        EXPECT_NEAR(std::abs(plane->normal_0.dot(oracle.normal)), 1, 1e-5);
      }
    }
  }
  EXPECT_GT(planes, 500);
  EXPECT_GT(none, 50);
}

// Two lines: of one laser in two scans, of two lasers in two scans, of two lasers in one scan.
TEST(ScanGrid, APlaneNeedsTwoLasersOfTheOthersAndIsCertainIfOneScanHasBoth) {
  const auto line = [](unsigned scan, unsigned laser, double y) {
    std::vector<MapPoint> out;
    for (double x = 0.1; x < 0.95; x += 0.1) out.push_back({{x, y, 0.5}, laser, 5, 0, scan});
    return out;
  };
  ScanGrid grid(kLattice, kSigma);
  auto both = line(0, 1, 0.2);
  for (const MapPoint& point : line(0, 2, 0.8)) both.push_back(point);
  grid.add_scan(both, 10);
  grid.add_scan(line(1, 1, 0.3), 10);
  grid.add_scan(line(2, 1, 0.7), 10);
  const Vector3d q_0(0.5, 0.5, 0.5);
  EXPECT_FALSE(plane_of({grid, 0}, q_0).plane);
  grid.add_scan(line(3, 5, 0.5), 10);
  const auto of_lines = plane_of({grid, 0}, q_0).plane, of_both = plane_of({grid, 1}, q_0).plane;
  ASSERT_TRUE(of_lines && of_both);
  EXPECT_GT(of_lines->variance, 0.05 * 0.05);
  EXPECT_LT(of_both->variance, 0.05 * 0.05);
}

TEST(ScanGrid, AClearedGridIsAsANewOne) {
  std::mt19937 generator(3);
  const auto scans = random_scans(generator);
  ScanGrid used(kLattice, kSigma), fresh(kLattice, kSigma);
  for (const auto& points : scans) used.add_scan(points, 10);
  used.clear();
  used.add_scan(scans[1], 10);
  fresh.add_scan(scans[1], 10);
  for (int cube = 0; cube < 20; ++cube) {
    const Vector3d q_0(cube % 5 + 0.5, cube / 5 + 0.5, 0.5);
    const auto plane = plane_of({used, kNoScan}, q_0).plane, expected = plane_of({fresh, kNoScan}, q_0).plane;
    ASSERT_EQ(plane.has_value(), expected.has_value());
    if (plane) {
      EXPECT_EQ(plane->variance, expected->variance);
    }
    EXPECT_FALSE(plane_of({used, 0}, q_0).plane);
  }
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
