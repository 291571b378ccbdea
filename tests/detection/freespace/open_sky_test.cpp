#include "detection/freespace/open_sky.hpp"

#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "detection/freespace/ray_image.hpp"
#include "support/detection/standing_scene.hpp"

namespace mapless {
namespace MAPLESS_FILE {

constexpr double kDegree = std::numbers::pi / 180;
constexpr int kColumns = 720;  // half a degree
constexpr int kRow = 11;       // of a VLP-16: 7 degrees up

// A wall from -30 to 30 degrees about the axis ahead, higher than the highest laser, on ground that the
// lasers below the horizon see all around. `code`: of rays into the sky.
CompensatedScan wall_on_ground(ReturnCode code) {
  const double half_width_m = 10 * std::tan(30 * kDegree);
  test::ToyScene scene = test::with_columns(
      test::standing({test::toy_ground(-1), test::toy_box({10.5, 0, 2}, {0.5, half_width_m, 8})}, "VLP-16"),
      kColumns);
  scene.empty_code = code;
  return test::cast(scene);
}

// Angle between the beam of a cell and the axis ahead, about the vertical [deg].
double off_ahead_deg(const LidarScan& scan, int row, int column) {
  const double azimuth =
      scan.model->hub_angle(column) + scan.model->lasers[static_cast<std::size_t>(row)].azimuth_offset_rad;
  return std::abs(std::remainder(azimuth, 2 * std::numbers::pi)) / kDegree;
}

std::size_t index(const LidarScan& scan, int row, int column) {
  return static_cast<std::size_t>(row * scan.columns + column);
}

TEST(OpenSky, IsWhereNoRayAboutReturns) {
  const CompensatedScan compensated = wall_on_ground(ReturnCode::faulty);
  const LidarScan& scan = *compensated.scan;
  const std::vector<bool> open = open_sky(scan);
  const RayImage rays(compensated);
  int free = 0;
  for (int c = 0; c < scan.columns; ++c) {
    const double off_deg = off_ahead_deg(scan, kRow, c);
    if (std::abs(off_deg - 37.5) < 2) continue;
    const bool expected = off_deg > 37.5;
    ASSERT_EQ(open[index(scan, kRow, c)], expected) << off_deg << " degrees off the axis ahead";
    if (!expected) continue;
    ++free;
    EXPECT_EQ(rays.range_m(kRow, c), static_cast<float>(scan.model->max_range_m));
  }
  EXPECT_GT(free, kColumns / 2);
  // 1 degree up, the next laser below sees the ground.
  for (int c = 0; c < scan.columns; ++c) EXPECT_FALSE(open[index(scan, 8, c)]);
}

TEST(OpenSky, IsNotAskedForWhereTheRecordingSaysIt) {
  EXPECT_TRUE(open_sky(*wall_on_ground(ReturnCode::nothing).scan).empty());
}

// The scan without the returns of the cells for which `covered` holds.
LidarScan without(const LidarScan& scan, const std::function<bool(int row, int column)>& covered) {
  LidarScan out = scan;
  for (int l = 0; l < scan.rows(); ++l) {
    for (int c = 0; c < scan.columns; ++c) {
      if (covered(l, c)) out.cells[index(scan, l, c)] = empty_cell(ReturnCode::absent);
    }
  }
  return out;
}

TEST(OpenSky, IsNotWhereTheSensorIsCoveredOrPacketsAreLost) {
  const CompensatedScan compensated = wall_on_ground(ReturnCode::faulty);
  const LidarScan& scan = *compensated.scan;
  const auto behind = [&](int row, int column) { return off_ahead_deg(scan, row, column) > 120; };
  const LidarScan lost = without(scan, behind);
  const LidarScan covered =
      without(scan, [&](int row, int column) { return row < 6 && behind(row, column); });
  const std::vector<bool> open = open_sky(lost), above = open_sky(covered);
  for (int l = 0; l < scan.rows(); ++l) {
    for (int c = 0; c < scan.columns; ++c) {
      if (off_ahead_deg(scan, l, c) < 121) continue;  // lasers of one column differ by .3 degrees
      EXPECT_FALSE(open[index(scan, l, c)]);
      // Rows 6 and 7 still see the ground, so the sky above is open; what is covered below them is not.
      EXPECT_EQ(above[index(scan, l, c)], l > 8) << l;
    }
  }
}

// A pane of 14 degrees in the wall.
TEST(OpenSky, IsNotAPane) {
  const CompensatedScan compensated = wall_on_ground(ReturnCode::faulty);
  const LidarScan& scan = *compensated.scan;
  const auto pane = [&](int row, int column) { return row > 4 && off_ahead_deg(scan, row, column) < 7; };
  const std::vector<bool> open = open_sky(without(scan, pane));
  for (int l = 0; l < scan.rows(); ++l) {
    for (int c = 0; c < scan.columns; ++c) {
      EXPECT_FALSE(pane(l, c) && open[index(scan, l, c)]);
    }
  }
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
