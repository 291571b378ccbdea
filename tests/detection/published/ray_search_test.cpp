#include "detection/published/ray_search.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include <gtest/gtest.h>
#include <tbb/parallel_for.h>

#include "oracle/ray_search_oracle.hpp"
#include "support/toy_scene.hpp"

namespace mapless {
namespace MAPLESS_FILE {

using Eigen::Vector3d;
using test::OracleRay;
using test::RaySearchOracle;

constexpr double kDegree = std::numbers::pi / 180;

struct Motion {
  std::string name;
  double speed;     // m/s
  double yaw_rate;  // rad/s, counter-clockwise
};

void PrintTo(const Motion& motion, std::ostream* out) { *out << motion.name; }

/// A scan without returns: the search looks at where the rays are, not at where they end.
std::shared_ptr<const LidarScan> rays_only(std::string_view sensor) {
  test::ToyScene scene;
  scene.model = std::make_shared<const LidarModel>(named_model(sensor));
  scene.trajectory = std::make_shared<StationaryTrajectory>();
  return test::cast_scan(scene, 0).scan;
}

std::shared_ptr<const LidarScan> with_cells(const LidarScan& scan, const std::vector<std::int32_t>& cells) {
  auto copy = std::make_shared<LidarScan>(scan);
  copy->cells = cells;
  return copy;
}

/// Points all around, a little beyond the highest and lowest laser, from 1 to 100 m as evenly in its
/// logarithm, seen from where the sensor is at any instant of the scan.
std::vector<Vector3d> random_points(const LidarScan& scan, const Trajectory& trajectory, int count,
                                    unsigned seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  const double lowest = scan.model->lasers.front().elevation_rad - kDegree;
  const double highest = scan.model->lasers.back().elevation_rad + kDegree;
  std::vector<Vector3d> points;
  const Vector3d begin_0 = trajectory.at(scan.start).T_v0.inverse().translation();
  const Vector3d end_0 = trajectory.at(scan.end()).T_v0.inverse().translation();
  while (points.size() < static_cast<std::size_t>(count)) {
    const double azimuth = 2 * std::numbers::pi * unit(random);
    const double elevation = lowest + (highest - lowest) * unit(random);
    const double range = std::pow(100.0, unit(random));
    const int column = static_cast<int>(unit(random) * scan.columns);
    const Vector3d p_v = range * Vector3d(std::cos(elevation) * std::cos(azimuth),
                                          std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
    const Vector3d p_0 = trajectory.at(scan.column_time(column)).T_v0.inverse() * p_v;
    if ((p_0 - begin_0).norm() > 1 && (p_0 - end_0).norm() > 1) points.push_back(p_0);
  }
  return points;
}

struct Agreement {
  int same = 0;
  int other = 0;
  double worst_m = 0;  // how much farther the ray found was than the nearest
};

/// Counts as the same a ray exactly as near. Distances are the oracle's own: nothing of what the search says
/// of them is believed.
Agreement compare(const CompensatedScan& compensated, const Trajectory& trajectory,
                  const std::vector<Vector3d>& points) {
  const RaySearch search(compensated);
  const RaySearchOracle oracle(*compensated.scan, trajectory);
  std::vector<double> excess(points.size());
  tbb::parallel_for(std::size_t{0}, points.size(), [&](std::size_t i) {
    const NearestRay found = search.nearest(points[i]);
    const OracleRay nearest = oracle.nearest(points[i]);
    excess[i] = found.found()
                    ? oracle.ray(found.laser, found.column, points[i]).distance_m - nearest.distance_m
                    : std::numeric_limits<double>::infinity();
  });
  Agreement answer;
  for (const double e : excess) {
    ++(e <= 1e-9 ? answer.same : answer.other);
    answer.worst_m = std::max(answer.worst_m, e);
  }
  return answer;
}

class RaySearchAgreement : public testing::TestWithParam<std::tuple<std::string, Motion>> {};

TEST_P(RaySearchAgreement, WithBruteForceOverAllRays) {
  const auto& [sensor, motion] = GetParam();
  const auto trajectory = test::drive(motion.speed, motion.yaw_rate);
  const auto scan = rays_only(sensor);
  const CompensatedScan compensated = compensate(scan, *trajectory);
  const unsigned seed = 20180918;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  const Agreement agreement =
      compare(compensated, *trajectory, random_points(*scan, *trajectory, 2000, seed));
  EXPECT_LE(agreement.other, 2);  // 99.9 %
  EXPECT_LT(agreement.worst_m, 0.02);
}

INSTANTIATE_TEST_SUITE_P(AllModels, RaySearchAgreement,
                         testing::Combine(testing::Values("HDL-64E-S2", "HDL-64E-S3", "VLP-16", "OS1-128"),
                                          testing::Values(Motion{"still", 0, 0}, Motion{"driving", 15, 0.2},
                                                          Motion{"turning_with_the_spin", 0, -180 * kDegree},
                                                          Motion{"turning_against_the_spin", 0,
                                                                 180 * kDegree})),
                         [](const auto& instance) {
                           std::string name =
                               std::get<0>(instance.param) + "_" + std::get<1>(instance.param).name;
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

// Of the points a scan measured, each lies on the ray that measured it.
TEST(RaySearch, GivesAScansOwnPointsTheirOwnRays) {
  for (const double yaw_rate : {0.0, -180 * kDegree, 180 * kDegree}) {
    SCOPED_TRACE(yaw_rate);
    const auto scene = test::toy_room("HDL-64E-S2", test::drive(3, yaw_rate));
    const CompensatedScan compensated = compensate(test::cast_scan(scene, 0).scan, *scene.trajectory);
    const RaySearch search(compensated);
    const auto& returns = compensated.scan->returns;
    std::atomic<int> own = 0;
    tbb::parallel_for(std::size_t{0}, returns.size(), [&](std::size_t i) {
      const NearestRay ray = search.nearest(compensated.points_0[i]);
      if (ray.laser == returns[i].laser && ray.column == returns[i].column) ++own;
    });
    EXPECT_GE(own, 0.995 * static_cast<double>(returns.size()));
  }
}

// The nearest ray is found within a limit a little beyond it, and none within one a little short of it.
TEST(RaySearch, FindsRaysWithinALimit) {
  const auto trajectory = test::drive(15, 0.2);
  const auto scan = rays_only("HDL-64E-S2");
  const CompensatedScan compensated = compensate(scan, *trajectory);
  const RaySearch search(compensated);
  for (const Vector3d& q : random_points(*scan, *trajectory, 500, 4)) {
    const NearestRay nearest = search.nearest(q);
    ASSERT_TRUE(nearest.found());
    const NearestRay within = search.nearest(q, nearest.distance_m + 1e-6);
    EXPECT_EQ(within.laser, nearest.laser);
    EXPECT_EQ(within.column, nearest.column);
    EXPECT_FALSE(search.nearest(q, nearest.distance_m - 1e-6).found());
    EXPECT_LE(nearest.range_m, search.longest_range(q));
  }
}

// The distance and the foot are those of the ray that is named.
TEST(RaySearch, MeasuresToTheRayItNames) {
  const auto trajectory = test::drive(15, 1);
  const auto scan = rays_only("HDL-64E-S2");
  const CompensatedScan compensated = compensate(scan, *trajectory);
  const RaySearch search(compensated);
  const RaySearchOracle oracle(*scan, *trajectory);
  for (const Vector3d& q : random_points(*scan, *trajectory, 500, 3)) {
    const NearestRay found = search.nearest(q);
    ASSERT_TRUE(found.found());
    const OracleRay ray = oracle.ray(found.laser, found.column, q);
    EXPECT_NEAR(found.distance_m, ray.distance_m, 1e-6);
    EXPECT_NEAR(found.range_m, ray.range_m, 1e-6);
  }
}

// The first and the last column look in nearly the same direction, an instant apart; with a sensor that turns
// with its spin, whole sectors are seen twice, against it not at all.
TEST(RaySearch, AgreesAtTheSeam) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> unit(0, 1);
  for (const double yaw_rate : {0.0, -180 * kDegree, 180 * kDegree}) {
    SCOPED_TRACE(yaw_rate);
    const auto trajectory = test::drive(10, yaw_rate);
    const auto scan = rays_only("HDL-64E-S2");
    const CompensatedScan compensated = compensate(scan, *trajectory);
    const RaySearchOracle oracle(*scan, *trajectory);
    std::vector<Vector3d> points;
    for (int i = 0; i < 1000; ++i) {
      const int laser = static_cast<int>(unit(random) * scan->rows());
      const int from_seam = static_cast<int>(unit(random) * 120);
      const int column = i % 2 == 0 ? from_seam : scan->columns - 1 - from_seam;
      const double range = 2 + 50 * unit(random);
      points.push_back(oracle.origin_0(laser, column) + range * oracle.direction_0(laser, column) +
                       0.02 * Vector3d(unit(random), unit(random), unit(random)));
    }
    const Agreement agreement = compare(compensated, *trajectory, points);
    EXPECT_LE(agreement.other, 5);
    EXPECT_LT(agreement.worst_m, 0.02);
  }
}

TEST(RaySearch, PassesOverALaserThatNeverFired) {
  const auto trajectory = test::drive(10, 0.5);
  const auto full = rays_only("HDL-64E-S3");
  std::vector<std::int32_t> cells = full->cells;
  const auto columns = static_cast<std::ptrdiff_t>(full->columns);
  std::fill(cells.begin() + 20 * columns, cells.begin() + 21 * columns, empty_cell(ReturnCode::absent));
  const auto scan = with_cells(*full, cells);
  const CompensatedScan compensated = compensate(scan, *trajectory);
  const Agreement agreement = compare(compensated, *trajectory, random_points(*scan, *trajectory, 2000, 6));
  EXPECT_LE(agreement.other, 2);
  EXPECT_LT(agreement.worst_m, 0.02);
  const RaySearch search(compensated);
  for (const Vector3d& q : random_points(*scan, *trajectory, 500, 7)) EXPECT_NE(search.nearest(q).laser, 20);
}

TEST(RaySearch, FindsNothingInAScanThatHasNoRays) {
  const auto full = rays_only("VLP-16");
  const std::vector<std::int32_t> cells(full->cells.size(), empty_cell(ReturnCode::absent));
  const StationaryTrajectory trajectory;
  const CompensatedScan compensated = compensate(with_cells(*full, cells), trajectory);
  EXPECT_FALSE(RaySearch(compensated).nearest({5, 1, 0}).found());
}

// Straight up, straight down, and at the sensor itself no azimuth is better than another: whatever ray is
// named has to be a real one, with its true distance.
TEST(RaySearch, StaysSoundAroundTheSensor) {
  const auto trajectory = test::drive(10, 180 * kDegree);
  for (const char* sensor : {"HDL-64E-S2", "VLP-16"}) {
    const auto scan = rays_only(sensor);
    const CompensatedScan compensated = compensate(scan, *trajectory);
    const RaySearch search(compensated);
    const RaySearchOracle oracle(*scan, *trajectory);
    for (const Vector3d& q :
         {Vector3d(0, 0, 0), Vector3d(0.5, 0, 3), Vector3d(0.5, 0, -2), Vector3d(0, 0, 1e-9),
          Vector3d(0, 0, 50), Vector3d(1e6, 1e6, 0), Vector3d(-3e5, 0, 1e4)}) {
      const NearestRay found = search.nearest(q);
      if (!found.found()) continue;
      ASSERT_LT(found.laser, scan->rows());
      ASSERT_LT(found.column, scan->columns);
      EXPECT_GE(found.range_m, 0);
      EXPECT_GE(oracle.ray(found.laser, found.column, q).distance_m, oracle.nearest(q).distance_m - 1e-6);
    }
  }
}

// What lies right behind a beam is not on it: rays go one way only.
TEST(RaySearch, DoesNotLookBackwards) {
  const auto scan = rays_only("VLP-16");
  const StationaryTrajectory trajectory;
  const CompensatedScan compensated = compensate(scan, trajectory);
  const RaySearch search(compensated);
  const RaySearchOracle oracle(*scan, trajectory);
  for (int column = 0; column < scan->columns; column += 97) {
    const Vector3d q = oracle.origin_0(0, column) - 20 * oracle.direction_0(0, column);
    const NearestRay found = search.nearest(q);
    ASSERT_TRUE(found.found());
    EXPECT_GT(
        (q - oracle.origin_0(found.laser, found.column)).dot(oracle.direction_0(found.laser, found.column)),
        0);
  }
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
