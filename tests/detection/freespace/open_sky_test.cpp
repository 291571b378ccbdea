#include "detection/freespace/open_sky.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "detection/freespace/ray_image.hpp"
#include "support/detection/run_detector.hpp"
#include "support/detection/standing_scene.hpp"
#include <mapless/detection/detector.hpp>

namespace mapless {
namespace MAPLESS_FILE {

constexpr double kDegree = std::numbers::pi / 180;
constexpr int kColumns = 720;  // half a degree
constexpr int kRow = 11;       // of a VLP-16: 7 degrees up

// Within `half_deg` of the axis ahead, higher than the highest laser.
test::ToyBody wall(double half_deg) {
  return test::toy_box({10.5, 0, 2}, {0.5, 10 * std::tan(half_deg * kDegree), 8});
}

// A wall on ground that the lasers below the horizon see all around. `code`: of rays into the sky.
CompensatedScan wall_on_ground(ReturnCode code, double half_deg = 30) {
  test::ToyScene scene =
      test::with_columns(test::standing({test::toy_ground(-1), wall(half_deg)}, "VLP-16"), kColumns);
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

// The scan with a return in every cell.
LidarScan full(LidarScan scan) {
  std::fill(scan.cells.begin(), scan.cells.end(), 0);
  return scan;
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

// Of a sensor all of whose lasers have returned all around.
std::vector<bool> sky(const LidarScan& scan) {
  OpenSky open_sky;
  (void)open_sky.of_next(full(scan));
  return open_sky.of_next(scan);
}

TEST(OpenSky, IsWhereNoRayAboutReturns) {
  const CompensatedScan compensated = wall_on_ground(ReturnCode::faulty);
  const LidarScan& scan = *compensated.scan;
  const std::vector<bool> open = sky(scan);
  int free = 0;
  for (int c = 0; c < scan.columns; ++c) {
    const double off_deg = off_ahead_deg(scan, kRow, c);
    if (std::abs(off_deg - 33) < 1) continue;
    const bool expected = off_deg > 33;
    ASSERT_EQ(open[index(scan, kRow, c)], expected) << off_deg << " degrees off the axis ahead";
    free += expected ? 1 : 0;
  }
  EXPECT_GT(free, kColumns / 2);
}

// Of a gap of 48 degrees 33 are 7.5 and more from what returns; all but 3 at either side are linked to these.
// A gap of 12 degrees is nowhere that wide.
TEST(OpenSky, IsWideSomewhere) {
  const CompensatedScan compensated = wall_on_ground(ReturnCode::faulty);
  const LidarScan& scan = *compensated.scan;
  for (const double half_deg : {24., 6.}) {
    const auto gap = [&](int row, int column) {
      return row > 4 && off_ahead_deg(scan, row, column) < half_deg;
    };
    const std::vector<bool> open = sky(without(full(scan), gap));
    for (int c = 0; c < scan.columns; ++c) {
      const double off_deg = off_ahead_deg(scan, kRow, c);
      if (std::abs(off_deg - (half_deg - 3)) < 1) continue;
      EXPECT_EQ(open[index(scan, kRow, c)], half_deg == 24 && off_deg < half_deg - 3) << off_deg;
    }
  }
}

// One laser that returns nothing, of glass or by a fault, 2 degrees and 4 from the next.
TEST(OpenSky, IsNotBetweenLasersThatReturn) {
  const CompensatedScan compensated = wall_on_ground(ReturnCode::faulty);
  const auto stripe = [](int row, int) { return row == kRow; };
  for (const double stretched : {1., 2.}) {
    LidarScan scan = without(full(*compensated.scan), stripe);
    LidarModel model = *scan.model;
    for (Laser& laser : model.lasers) laser.elevation_rad *= stretched;
    scan.model = std::make_shared<const LidarModel>(model);
    const std::vector<bool> open = sky(scan);
    EXPECT_EQ(std::count(open.begin(), open.end(), true), 0) << stretched;
  }
}

TEST(OpenSky, IsNotAskedForWhereTheRecordingSaysIt) {
  EXPECT_TRUE(sky(*wall_on_ground(ReturnCode::nothing).scan).empty());
}

// A scan under a roof has no sky: its missing returns are faulty ones, as those before said.
TEST(OpenSky, IsNotAskedForOnceTheRecordingHasSaidIt) {
  const LidarScan told = *wall_on_ground(ReturnCode::nothing).scan;
  const LidarScan later = *wall_on_ground(ReturnCode::faulty).scan;
  OpenSky open_sky;
  (void)open_sky.of_next(full(told));
  EXPECT_FALSE(open_sky.of_next(later).empty());
  (void)open_sky.of_next(told);
  EXPECT_TRUE(open_sky.of_next(later).empty());
}

TEST(OpenSky, IsNotWhereTheSensorIsCoveredOrPacketsAreLost) {
  const CompensatedScan compensated = wall_on_ground(ReturnCode::faulty);
  const LidarScan& scan = *compensated.scan;
  const auto behind = [&](int row, int column) { return off_ahead_deg(scan, row, column) > 120; };
  const LidarScan lost = without(scan, behind);
  const LidarScan covered =
      without(scan, [&](int row, int column) { return row < 6 && behind(row, column); });
  const std::vector<bool> open = sky(lost), above = sky(covered);
  for (int l = 0; l < scan.rows(); ++l) {
    for (int c = 0; c < scan.columns; ++c) {
      if (off_ahead_deg(scan, l, c) < 121) continue;  // lasers of one column differ by .3 degrees
      EXPECT_FALSE(open[index(scan, l, c)]);
      // Rows 6 and 7 still see the ground, so the sky above is open; what is covered below them is not.
      EXPECT_EQ(above[index(scan, l, c)], l > 7) << l;
    }
  }
}

// What has never returned may be covered: here all but 102 degrees of the turn, 1 to either side of the wall.
TEST(OpenSky, IsNotWhereNothingHasReturnedYet) {
  const LidarScan scan = *wall_on_ground(ReturnCode::faulty, 50).scan;
  OpenSky open_sky;
  const std::vector<bool> first = open_sky.of_next(scan);
  EXPECT_EQ(std::count(first.begin(), first.end(), true), 0);
  (void)open_sky.of_next(full(scan));
  EXPECT_EQ(open_sky.of_next(scan), sky(scan));
}

// 62 degrees are less than a quarter.
TEST(OpenSky, IsWhereALaserHardlyReturns) {
  const LidarScan scan = *wall_on_ground(ReturnCode::faulty, 30).scan;
  EXPECT_EQ(OpenSky().of_next(scan), sky(scan));
}

// Each scan of a point cloud has a model of its own, which begins where the scan does.
TEST(OpenSky, IsLearntFromScansThatBeginElsewhere) {
  const LidarScan scan = *wall_on_ground(ReturnCode::faulty, 50).scan;
  LidarScan turned = full(scan);
  LidarModel model = *scan.model;
  model.start_azimuth_rad = model.hub_angle(200);
  turned.model = std::make_shared<const LidarModel>(model);
  OpenSky open_sky;
  (void)open_sky.of_next(
      without(turned, [&](int row, int column) { return off_ahead_deg(turned, row, column) > 120; }));
  const std::vector<bool> open = open_sky.of_next(scan);
  for (int c = 0; c < scan.columns; ++c) {
    const double off_deg = off_ahead_deg(scan, kRow, c);
    if (std::abs(off_deg - 53) < 1 || std::abs(off_deg - 121) < 1) continue;
    EXPECT_EQ(open[index(scan, kRow, c)], off_deg > 53 && off_deg < 121) << off_deg;
  }
}

TEST(OpenSky, IsFreeToTheMaximumRange) {
  const CompensatedScan compensated = wall_on_ground(ReturnCode::faulty);
  const LidarScan& scan = *compensated.scan;
  const std::vector<bool> open = sky(scan);
  const RayImage rays(compensated, nullptr, open), alone(compensated);
  for (int l = 0; l < scan.rows(); ++l) {
    for (int c = 0; c < scan.columns; ++c) {
      if (!open[index(scan, l, c)]) continue;
      EXPECT_EQ(rays.range_m(l, c), static_cast<float>(scan.model->max_range_m));
      EXPECT_TRUE(std::isnan(alone.range_m(l, c)));
    }
  }
}

// Points found moving of a box that flies by before the sky, in scans 5 to 25, behind the sensor. In those
// before, the sensor was in a room: all its rays returned.
std::size_t flying_points_found(bool learn) {
  test::ToyScene room = test::toy_room("VLP-16", std::make_shared<StationaryTrajectory>());
  test::ToyBody box = test::toy_box({-10, -6, 2}, {0.5, 0.5, 0.5});
  box.velocity_0 = {0, 4, 0};
  test::ToyScene field = room;
  field.world = {test::toy_ground(-1), wall(50), box};
  field.empty_code = ReturnCode::faulty;
  Detector detector;
  std::size_t moving = 0;
  for (int k = 0; k < 26; ++k) {
    if (k < 5 && learn) detector.learn_own_vehicle(*test::cast_scan(room, k).scan, *room.trajectory);
    if (k >= 5)
      moving += test::moving_points(detector.process(test::cast_scan(field, k).scan, *field.trajectory));
  }
  return moving + test::moving_points(detector.flush());
}

// Three lasers and 28 columns see the box, 1,700 times in 20 scans. Without the room only the box itself
// shows which rays return, those near its path.
TEST(OpenSky, IsKnownFromScansThatAreNotLabelled) {
  EXPECT_GT(flying_points_found(true), 1200U);
  EXPECT_LT(flying_points_found(false), 400U);
}

// A pane of 14 degrees in the wall.
TEST(OpenSky, IsNotAPane) {
  const CompensatedScan compensated = wall_on_ground(ReturnCode::faulty);
  const LidarScan& scan = *compensated.scan;
  const auto pane = [&](int row, int column) { return row > 4 && off_ahead_deg(scan, row, column) < 7; };
  const std::vector<bool> open = sky(without(scan, pane));
  for (int l = 0; l < scan.rows(); ++l) {
    for (int c = 0; c < scan.columns; ++c) {
      EXPECT_FALSE(pane(l, c) && open[index(scan, l, c)]);
    }
  }
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
