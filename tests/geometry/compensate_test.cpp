#include <cmath>
#include <numbers>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "support/cast_rays.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/geometry/compensated_scan.hpp>

namespace mapless {
namespace MAPLESS_FILE {

using test::awkward_model;
using test::cast_rays;
using test::ScrewTrajectory;

constexpr double kDegree = std::numbers::pi / 180;
const Time kStart = Time::from_nanoseconds(1'317'042'272'283'701'593);

Vector6d velocity(double forward_mps, double turn_dps) {
  // The world moves backwards and turns the other way, seen from the sensor.
  return (Vector6d() << -forward_mps, 0.5, 0.2, 0.1, -0.05, -turn_dps * kDegree).finished();
}

// Drives at 30 m/s while turning at 200 degrees per second, from somewhere far from the origin.
ScrewTrajectory fast_turn() {
  const SE3 T_v0 = SE3::exp((Vector6d() << 800, -300, 20, 0.1, 0.2, 2).finished());
  return {T_v0, velocity(30, 200), kStart - Duration::from_seconds(0.1),
          kStart + Duration::from_seconds(0.2)};
}

// Ranges that vary from ray to ray, up to 100 m: compensation does not depend on the surfaces.
std::optional<double> some_range(const Eigen::Vector3d&, const Eigen::Vector3d& direction_0) {
  const double range = 50 + 50 * std::sin(97 * direction_0.x() + 13 * direction_0.y());
  return range < 2 ? std::nullopt : std::optional(range);
}

std::shared_ptr<LidarScan> some_scan(const Trajectory& trajectory) {
  return std::make_shared<LidarScan>(cast_rays(awkward_model(16, 1000), kStart, trajectory, some_range));
}

// Every seventh point is far from the instant of its column.
std::shared_ptr<LidarScan> scan_with_stray_times(const Trajectory& trajectory) {
  auto scan = some_scan(trajectory);
  std::mt19937 random(1);
  std::uniform_int_distribution<std::int32_t> any_time(0, 99'999'999);
  for (std::size_t i = 0; i < scan->returns.size(); i += 7) scan->returns[i].time_ns = any_time(random);
  return scan;
}

double largest_error_m(const CompensatedScan& compensated, const Trajectory& trajectory) {
  double largest = 0;
  const LidarScan& scan = *compensated.scan;
  for (std::size_t i = 0; i < scan.returns.size(); ++i) {
    const LidarReturn& r = scan.returns[i];
    const Eigen::Vector3d exact = trajectory.at(scan.time_of(r)).T_v0.inverse() * r.position_v.cast<double>();
    largest = std::max(largest, (compensated.points_0[i] - exact).norm());
  }
  return largest;
}

TEST(Compensate, AgreesWithThePoseOfEveryPointWithinTenMicrometres) {
  const ScrewTrajectory trajectory = fast_turn();
  const auto scan = some_scan(trajectory);
  ASSERT_GT(scan->returns.size(), 14'000u);
  EXPECT_LT(largest_error_m(compensate(scan, trajectory), trajectory), 1e-5);
}

TEST(Compensate, AgreesWithThePoseOfPointsFarFromTheInstantOfTheirColumn) {
  const ScrewTrajectory trajectory = fast_turn();
  const auto scan = scan_with_stray_times(trajectory);
  EXPECT_LT(largest_error_m(compensate(scan, trajectory), trajectory), 1e-5);
}

TEST(Compensate, AgreesForSmoothTrajectories) {
  const Time end = kStart + Duration::from_seconds(0.15);
  const SE3 T_start = SE3::exp((Vector6d() << 3, 4, 5, 0.3, 0.2, 0.1).finished());
  const SE3 T_end = SE3::exp(velocity(2, 20)) * T_start;
  const GaussianProcessTrajectory trajectory(
      {{kStart, T_start, velocity(20, 150)}, {end, T_end, velocity(10, 180)}}, "test");
  EXPECT_LT(largest_error_m(compensate(some_scan(trajectory), trajectory), trajectory), 5e-5);
}

// A float at 100 m has steps of 8 micrometres.
TEST(CompensateLocally, AgreesWithCompensateWithinSinglePrecision) {
  const ScrewTrajectory trajectory = fast_turn();
  const auto scan = scan_with_stray_times(trajectory);
  const CompensatedScan expected = compensate(scan, trajectory);
  const auto [compensated, local] = compensate_locally(scan, trajectory);
  EXPECT_TRUE(compensated.points_0.empty());
  EXPECT_EQ(compensated.column_states.size(), expected.column_states.size());
  EXPECT_EQ(local.origin_0, expected.column_T_0v.front().translation());
  ASSERT_EQ(local.points.size(), expected.points_0.size());
  for (std::size_t i = 0; i < local.points.size(); ++i) {
    const Eigen::Vector3d p_0 = local.origin_0 + local.points[i].cast<double>();
    ASSERT_LT((p_0 - expected.points_0[i]).norm(), 5e-5) << i;
  }
}

// Without motion the points stay where they are, to the last bit.
TEST(Compensate, AStationarySensorLeavesPointsUnchanged) {
  const StationaryTrajectory still;
  const auto scan = some_scan(still);
  const CompensatedScan compensated = compensate(scan, still);
  for (std::size_t i = 0; i < scan->returns.size(); ++i) {
    ASSERT_EQ(compensated.points_0[i], scan->returns[i].position_v.cast<double>());
  }
}

// A return lies on its own ray, its range from the ray's origin. Lasers fire at the instant of their column
// here.
TEST(Compensate, EveryRayEndsInItsReturn) {
  const ScrewTrajectory trajectory = fast_turn();
  auto model = std::make_shared<LidarModel>(*awkward_model(16, 1000));
  for (Laser& laser : model->lasers) laser.firing_offset = Duration();
  const auto scan = std::make_shared<LidarScan>(cast_rays(model, kStart, trajectory, some_range));
  const CompensatedScan compensated = compensate(scan, trajectory);
  ASSERT_EQ(compensated.column_states.size(), 1000u);
  for (std::size_t i = 0; i < scan->returns.size(); ++i) {
    const LidarReturn& r = scan->returns[i];
    const Eigen::Vector3d end = compensated.ray_origin_0(r.laser, r.column) +
                                r.range_m * compensated.ray_direction_0(r.laser, r.column);
    ASSERT_LT((end - compensated.points_0[i]).norm(), 2e-5) << i;  // positions are floats
    ASSERT_NEAR(compensated.ray_direction_0(r.laser, r.column).norm(), 1, 1e-12);
  }
}

TEST(Compensate, OneThreadAndSeveralGiveTheSameBytes) {
  const ScrewTrajectory trajectory = fast_turn();
  const auto scan = some_scan(trajectory);
  const CompensatedScan several = compensate(scan, trajectory);
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(compensate(scan, trajectory).points_0, several.points_0);
}

TEST(Compensate, RefusesACompensatedScan) {
  const StationaryTrajectory still;
  const auto scan = some_scan(still);
  scan->compensated_to = kStart;
  EXPECT_THROW((void)compensate(scan, still), InputError);
}

TEST(Compensate, RefusesATrajectoryThatEndsBeforeTheLastReturn) {
  const ScrewTrajectory longer = fast_turn();
  const auto scan = some_scan(longer);
  const Time last_column = scan->column_time(scan->columns - 1);
  const auto until = [](Time begin, Time end) { return ScrewTrajectory(SE3(), velocity(1, 1), begin, end); };
  EXPECT_THROW((void)compensate(scan, until(kStart, last_column)), TrajectoryDomainError);
  EXPECT_NO_THROW((void)compensate(scan, until(kStart, last_column + Duration::from_seconds(40e-6))));
  EXPECT_THROW((void)compensate(scan, until(kStart + Duration::from_nanoseconds(1), scan->end())),
               TrajectoryDomainError);
}

TEST(Compensate, AcceptsAnEmptyScan) {
  const StationaryTrajectory still;
  const auto nothing = [](const Eigen::Vector3d&, const Eigen::Vector3d&) { return std::optional<double>(); };
  const auto scan = std::make_shared<LidarScan>(cast_rays(awkward_model(4, 100), kStart, still, nothing));
  EXPECT_TRUE(compensate(scan, still).points_0.empty());
}

TEST(Compensate, RefusesANullScan) {
  EXPECT_THROW((void)compensate(nullptr, StationaryTrajectory()), ParameterError);
  EXPECT_THROW((void)compensate_locally(nullptr, StationaryTrajectory()), ParameterError);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
