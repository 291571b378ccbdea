#include "detection/evidence/slope_image.hpp"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "detection/evidence/collect_evidence.hpp"
#include "support/detection/standing_scene.hpp"
#include "support/local_points.hpp"

namespace mapless {
namespace MAPLESS_FILE {

using Eigen::Vector3d;
using test::cast;
using test::is_ahead;
using test::local_points;
using test::standing;
using test::wall_at;

constexpr const char* kSensor = "OS1-128";  // all lasers start at about one height

// Ground h below, in a direction e below the horizon, is h / sin e away: by h cos e / sin^2 e more per radian
// up, which is cot e per metre across. In a row it has one range.
TEST(SlopeImage, OfGroundIsTheCotangentOfItsElevation) {
  const CompensatedScan scan = cast(standing({test::toy_ground(-1.73)}, kSensor));
  const LocalPoints points = local_points(scan);
  const SlopeImage slopes(*scan.scan, points.points);
  int near = 0;
  for (std::size_t i = 0; i < points.points.size(); i += 13) {
    const Vector3d& p = scan.points_0[i];
    const double cotangent = p.head<2>().norm() / -p.z();
    if (cotangent > 6) continue;  // neighbours are 0.35 degrees apart, up to a twentieth of e
    ++near;
    EXPECT_NEAR(slopes.of(i, 1).up / cotangent, 1, 0.08);
    EXPECT_LT(slopes.of(i, 1).left, 0.1F);
  }
  EXPECT_GT(near, 500);
}

// A wall square to the axis ahead recedes by tan a per metre to the side, at azimuth a.
TEST(SlopeImage, OfAWallIsTheTangentOfItsAzimuth) {
  const CompensatedScan scan = cast(standing({wall_at(7)}, kSensor));
  const LocalPoints points = local_points(scan);
  const SlopeImage slopes(*scan.scan, points.points);
  int ahead = 0;
  for (std::size_t i = 0; i < points.points.size(); i += 13) {
    const Vector3d& p = scan.points_0[i];
    if (!is_ahead(scan, i) || std::abs(p.z()) > 0.1 * p.x()) continue;
    ++ahead;
    EXPECT_NEAR(slopes.of(i, 1).left, std::abs(p.y() / p.x()), 0.02);
    EXPECT_LT(slopes.of(i, 1).up, 0.15F);
  }
  EXPECT_GT(ahead, 200);
}

// At the edges of a box 3 m before a wall one neighbour is on the wall, where the range jumps by 80 m per
// metre: the other counts.
TEST(SlopeImage, OfAnEdgeIsThatOfItsOwnSide) {
  const CompensatedScan scan = cast(standing({wall_at(9), test::toy_box({6.5, 0, 0}, {0.5, 1, 1})}, kSensor));
  const LocalPoints points = local_points(scan);
  const SlopeImage slopes(*scan.scan, points.points);
  int beside = 0, above = 0;
  for (std::size_t i = 0; i < points.points.size(); ++i) {
    const Vector3d& p = scan.points_0[i];
    if (p.x() > 6.1 || p.x() < 0) continue;
    if (std::abs(p.y()) > 0.96 && std::abs(p.z()) < 0.5) {
      ++beside;
      EXPECT_LT(slopes.of(i, 1).left, 0.3F);
    }
    if (std::abs(p.y()) < 0.5 && p.z() > 0.96) {
      ++above;
      EXPECT_LT(slopes.of(i, 1).up, 0.3F);
    }
  }
  EXPECT_GT(beside, 10);
  EXPECT_GT(above, 10);
}

TEST(SlopeImage, WithoutNeighboursIsUnknown) {
  const CompensatedScan compensated = cast(standing({wall_at(7)}));
  LidarScan scan = *compensated.scan;
  const LocalPoints points = local_points(compensated);
  const std::size_t i = scan.returns.size() / 2;
  std::fill(scan.cells.begin(), scan.cells.end(), empty_cell(ReturnCode::absent));
  const SurfaceSlopes alone = SlopeImage(scan, points.points).of(i, 1);
  EXPECT_EQ(alone.up, SurfaceSlopes::kUnknown);
  EXPECT_EQ(alone.left, SurfaceSlopes::kUnknown);
}

// Lasers 2 degrees apart tolerate 0.36 m at 20 m, for what ground does between them. A wall that receded from
// 20 m by 0.25 m is at once seen to have done so; but above 5 degrees, where one laser meets it 0.07 m
// farther than the next.
TEST(SlopeImage, LetsAWallBeSeenToRecedeBetweenLasersFarApart) {
  const CompensatedScan query = cast(standing({wall_at(20)}, "VLP-16"));
  std::vector<RayImage> images;
  images.emplace_back(cast(standing({wall_at(20.25)}, "VLP-16")));
  const auto votes =
      collect_evidence(*query.scan, local_points(query), test::references(images, {1}), RayImage(query), {});
  int ahead = 0, seen_through = 0;
  for (std::size_t i = 0; i < votes.size(); ++i) {
    const Vector3d& p = query.points_0[i];
    if (p.x() < 0 || std::abs(p.y()) > 0.1 * p.x() || std::abs(p.z()) > 0.09 * p.x()) continue;
    ++ahead;
    seen_through += votes[i].total() > 0 ? 1 : 0;
  }
  EXPECT_GT(ahead, 200);
  EXPECT_EQ(seen_through, ahead);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
