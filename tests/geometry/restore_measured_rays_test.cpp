#include <cmath>
#include <numbers>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

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
const Time kMiddle = kStart + Duration::from_seconds(0.05);

ScrewTrajectory driving(double forward_mps, double turn_dps) {
  const Vector6d varpi = (Vector6d() << -forward_mps, 0, 0, 0, 0, -turn_dps * kDegree).finished();
  const SE3 T_v0 = SE3::exp((Vector6d() << 80, -30, 2, 0.1, 0.2, 2).finished());
  return {T_v0, varpi, kStart - Duration::from_seconds(0.1), kStart + Duration::from_seconds(0.2)};
}

std::optional<double> some_range(const Eigen::Vector3d&, const Eigen::Vector3d& direction_0) {
  const double range = 30 + 28 * std::sin(7 * direction_0.x() + 13 * direction_0.y());
  return range < 4 ? std::nullopt : std::optional(range);
}

// What another system makes of a scan: every point moved to the sensor frame at mid-scan.
LidarScan compensated_by_others(const LidarScan& measured, const Trajectory& trajectory) {
  LidarScan scan = measured;
  const SE3 T_c0 = trajectory.at(kMiddle).T_v0;
  for (LidarReturn& r : scan.returns) {
    const SE3 T_0v = trajectory.at(scan.time_of(r)).T_v0.inverse();
    r.position_v = (T_c0 * (T_0v * r.position_v.cast<double>())).cast<float>();
  }
  scan.compensated_to = kMiddle;
  return scan;
}

// What is left of such a cloud without times: column and time from the azimuth, of beams that leave from the
// axis.
void recover_times_from_azimuths(LidarScan& scan) {
  const LidarModel& model = *scan.model;
  for (LidarReturn& r : scan.returns) {
    const double azimuth =
        std::atan2(static_cast<double>(r.position_v.y()), static_cast<double>(r.position_v.x()));
    const double offset = model.lasers[static_cast<std::size_t>(r.laser)].azimuth_offset_rad;
    double turn = model.sign() * (azimuth - offset - model.start_azimuth_rad) / (2 * std::numbers::pi);
    turn -= std::floor(turn);
    r.column = static_cast<std::int32_t>(turn * scan.columns);
    r.time_ns = static_cast<std::int32_t>(turn * scan.columns *
                                          static_cast<double>(scan.column_period.nanoseconds()));
  }
  scan.time_source = Provenance::recovered_from_angle;
}

void expect_consistent_cells(const LidarScan& scan) {
  ASSERT_EQ(scan.cells.size(),
            static_cast<std::size_t>(scan.rows()) * static_cast<std::size_t>(scan.columns));
  for (std::size_t i = 0; i < scan.returns.size(); ++i) {
    const LidarReturn& r = scan.returns[i];
    const std::int32_t shown = scan.cell(r.laser, r.column);
    ASSERT_GE(shown, 0);
    ASSERT_LE(scan.returns[static_cast<std::size_t>(shown)].range_m, r.range_m);
    if (i == 0) continue;
    const LidarReturn& before = scan.returns[i - 1];
    ASSERT_LT(std::tie(before.laser, before.column, before.input_index),
              std::tie(r.laser, r.column, r.input_index));
  }
}

TEST(RestoreMeasuredRays, InvertsCompensationIfTimesAreKnown) {
  const ScrewTrajectory trajectory = driving(30, 90);
  const LidarScan measured = cast_rays(awkward_model(16, 1000), kStart, trajectory, some_range);
  const LidarScan restored = restore_measured_rays(compensated_by_others(measured, trajectory), trajectory);
  EXPECT_FALSE(restored.compensated_to);
  EXPECT_EQ(restored.cells, measured.cells);
  ASSERT_EQ(restored.returns.size(), measured.returns.size());
  for (std::size_t i = 0; i < measured.returns.size(); ++i) {
    const LidarReturn& m = measured.returns[i];
    const LidarReturn& r = restored.returns[i];
    ASSERT_LT((m.position_v - r.position_v).norm(), 2e-5f) << i;  // two roundings to float at 60 m
    ASSERT_NEAR(m.range_m, r.range_m, 2e-5f) << i;
    ASSERT_EQ(m.column, r.column);
    ASSERT_EQ(m.time_ns, r.time_ns);
    ASSERT_EQ(m.input_index, r.input_index);
  }
}

// A reader of clouds places points by their azimuths, which compensation has changed.
TEST(RestoreMeasuredRays, FindsTheColumnsOfRaysWhoseTimesAreKnown) {
  const ScrewTrajectory trajectory = driving(30, 90);
  const LidarScan measured = cast_rays(awkward_model(16, 1000), kStart, trajectory, some_range);
  LidarScan compensated = compensated_by_others(measured, trajectory);
  LidarScan placed = compensated;
  recover_times_from_azimuths(placed);
  int moved = 0;
  for (std::size_t i = 0; i < placed.returns.size(); ++i) {
    moved += std::abs(placed.returns[i].column - compensated.returns[i].column) > 5;
    compensated.returns[i].column = placed.returns[i].column;
  }
  ASSERT_GT(moved, 1000);
  const LidarScan restored = restore_measured_rays(compensated, trajectory);
  EXPECT_EQ(restored.cells, measured.cells);
  ASSERT_EQ(restored.returns.size(), measured.returns.size());
  for (std::size_t i = 0; i < measured.returns.size(); ++i) {
    ASSERT_EQ(measured.returns[i].column, restored.returns[i].column) << i;
    ASSERT_LT((measured.returns[i].position_v - restored.returns[i].position_v).norm(), 2e-5f) << i;
  }
}

// Turning, the azimuths of a compensated cloud are off by up to half a scan's turn. The rays come back to a
// fraction of a column, except where the turn carried a direction past the seam.
TEST(RestoreMeasuredRays, RecoversColumnsFromAzimuths) {
  for (const double turn_dps : {-40.0, 0.0, 25.0, 40.0}) {
    SCOPED_TRACE(testing::Message() << turn_dps << " deg/s");
    auto model = std::make_shared<LidarModel>(*awkward_model(16, 2000));
    for (Laser& laser : model->lasers) {
      laser.firing_offset = Duration();
      laser.origin_h_m.head<2>().setZero();
    }
    const ScrewTrajectory trajectory = driving(15, turn_dps);
    const LidarScan measured = cast_rays(model, kStart, trajectory, some_range);
    LidarScan compensated = compensated_by_others(measured, trajectory);
    recover_times_from_azimuths(compensated);
    const LidarScan restored = restore_measured_rays(compensated, trajectory);
    expect_consistent_cells(restored);
    std::vector<const LidarReturn*> by_input(measured.input_size, nullptr);
    for (const LidarReturn& m : measured.returns) by_input[m.input_index] = &m;
    int same_column = 0, near_seam = 0;
    for (const LidarReturn& r : restored.returns) {
      const LidarReturn& m = *by_input[r.input_index];
      // Within what the sensor's own motion turns a direction by, at the seam, it may occur twice or not at
      // all.
      const int margin = static_cast<int>(std::abs(turn_dps) * 0.1 / 360 * 2000) + 25;
      if (m.column < margin || m.column >= 2000 - margin) {
        ++near_seam;
        continue;
      }
      ASSERT_LE(std::abs(m.column - r.column), 1);
      ASSERT_LT((m.position_v - r.position_v).norm(), 3e-3f);
      same_column += m.column == r.column;
    }
    const int inside = static_cast<int>(restored.returns.size()) - near_seam;
    EXPECT_GT(inside, 25'000);
    EXPECT_GT(same_column, 0.98 * inside);
  }
}

TEST(RestoreMeasuredRays, HandlesLasersOffTheAxisAndLateFirings) {
  const ScrewTrajectory trajectory = driving(15, 20);
  const LidarScan measured = cast_rays(awkward_model(16, 2000), kStart, trajectory, some_range);
  LidarScan compensated = compensated_by_others(measured, trajectory);
  recover_times_from_azimuths(compensated);
  const LidarScan restored = restore_measured_rays(compensated, trajectory);
  std::vector<const LidarReturn*> by_input(measured.input_size, nullptr);
  for (const LidarReturn& m : measured.returns) by_input[m.input_index] = &m;
  for (const LidarReturn& r : restored.returns) {
    const LidarReturn& m = *by_input[r.input_index];
    if (m.column < 40 || m.column > 1960) continue;
    ASSERT_LE(std::abs(m.column - r.column), 1);
    ASSERT_NEAR(m.time_ns, r.time_ns, 2'000);
  }
}

// Cells without a return keep their code.
TEST(RestoreMeasuredRays, KeepsTheCodesOfEmptyCells) {
  const ScrewTrajectory trajectory = driving(0, 0);
  LidarScan measured = cast_rays(awkward_model(4, 400), kStart, trajectory, some_range);
  std::int32_t* empty = nullptr;
  for (std::int32_t& cell : measured.cells) {
    if (cell < 0) empty = &cell;
  }
  ASSERT_NE(empty, nullptr);
  *empty = empty_cell(ReturnCode::faulty);
  const LidarScan restored = restore_measured_rays(compensated_by_others(measured, trajectory), trajectory);
  EXPECT_EQ(restored.cells, measured.cells);
}

TEST(RestoreMeasuredRays, RefusesAScanThatIsNotCompensated) {
  const ScrewTrajectory trajectory = driving(0, 0);
  const LidarScan measured = cast_rays(awkward_model(4, 100), kStart, trajectory, some_range);
  EXPECT_THROW((void)restore_measured_rays(measured, trajectory), InputError);
}

TEST(RestoreMeasuredRays, RefusesATrajectoryThatDoesNotCoverIt) {
  const ScrewTrajectory trajectory = driving(0, 0);
  LidarScan scan = cast_rays(awkward_model(4, 100), kStart, trajectory, some_range);
  scan.compensated_to = kStart + Duration::from_seconds(1);
  EXPECT_THROW((void)restore_measured_rays(scan, trajectory), TrajectoryDomainError);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
