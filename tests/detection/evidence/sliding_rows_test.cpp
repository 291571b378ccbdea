#include "detection/evidence/sliding_rows.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "detection/evidence/row_lines.hpp"
#include "support/detection/standing_scene.hpp"
#include "support/local_points.hpp"

namespace mapless {
namespace MAPLESS_FILE {

using Eigen::Vector3d;
using test::asked;
using test::cast;
using test::local_points;
using test::standing;

/// 10 m long, its side 3 m to the left of the sensor; at time 0 its rear end is `rear_m` ahead of it.
test::ToyBody lorry(double rear_m, double speed_mps) {
  test::ToyBody body = test::toy_box({rear_m + 5, 4.2, 0.3}, {5, 1.2, 1.6});
  body.velocity_0 = {speed_mps, 0, 0};
  return body;
}

struct Side {
  std::size_t points = 0, sliding = 0;
  std::size_t others = 0;  // of the ground and the house
};

struct Then {
  int gap;
  test::ToyScene scene;
  int number;
};

/// How many points of `query` have the votes of what slides.
Side heard(const CompensatedScan& query, const std::vector<Then>& then) {
  std::vector<RayImage> images;
  std::vector<int> gaps;
  for (const Then& t : then) {
    images.emplace_back(cast(t.scene, t.number));
    gaps.push_back(t.gap);
  }
  const auto votes =
      collect_votes(*query.scan, local_points(query), asked(images, gaps), RayImage(query), {});
  Side side;
  for (std::size_t i = 0; i < votes.size(); ++i) {
    const Vector3d& p = query.points_0[i];
    const bool sliding = votes[i].earlier == kSlidingVotes && votes[i].surface_seen && votes[i].seen_through;
    if (std::abs(p.y() - 3) < 0.02 && p.z() > -1.2 && p.z() < 1.8) {
      ++side.points;
      side.sliding += sliding ? 1 : 0;
    } else if (p.y() < 2.5 || p.y() > 6) {
      side.others += sliding ? 1 : 0;
    }
  }
  return side;
}

Side heard(const test::ToyScene& scene, int number, const std::vector<int>& gaps = {1, 2, 3, 4, 6, 8}) {
  std::vector<Then> then;
  for (const int gap : gaps) then.push_back({gap, scene, number - gap});
  return heard(cast(scene, number), then);
}

test::ToyWorld street() { return {test::toy_ground(-1.8), test::toy_box({0, 12, 0}, {60, 1, 8})}; }

test::ToyScene beside(const test::ToyBody& body) {
  test::ToyWorld world = street();
  world.push_back(body);
  return standing(world);
}

// Its rear end goes from 3.2 m behind the sensor to 2.4 m behind, in eight scans, its front from 6.8 m ahead:
// so of its side 9.2 m of 10 are where they were. Not all rows tell: some end where the ground begins.
TEST(SlidingRows, ALorryThatPassesSlowlyMovesAsAWhole) {
  for (const double speed : {1.0, -1.0, 2.0}) {
    SCOPED_TRACE(speed);
    const Side side = heard(beside(lorry(-4, speed)), 8);
    EXPECT_GT(side.points, 10000u);
    EXPECT_GT(side.sliding, side.points * 2 / 3);
    EXPECT_LT(side.others, side.points / 1000);
  }
}

TEST(SlidingRows, WhatStandsDoesNotSlideAlsoWhereTheSensorDrives) {
  for (const double speed : {0.0, 1.0, 8.0}) {
    SCOPED_TRACE(speed);
    test::ToyScene scene = beside(lorry(-4, 0));
    scene.trajectory = test::drive(speed, 0.1);
    EXPECT_EQ(heard(scene, 8).sliding, 0u);
  }
}

// Less than the two steps of a tenth of a metre that a rounded corner does not look like.
TEST(SlidingRows, AnEndThatHasHardlyRecededTellsNothing) {
  EXPECT_EQ(heard(beside(lorry(-4, 0.3)), 8).sliding, 0u);
}

// Behind a box that stands in line with it a lorry draws in: what is seen is one side whose front end stays.
TEST(SlidingRows, WhatBecomesShorterDoesNotSlide) {
  test::ToyScene scene = beside(lorry(-4, 1));
  scene.world.push_back(test::toy_box({4.7, 4.2, 0.3}, {2.5, 1.2, 1.6}));  // to 7.2 m
  EXPECT_EQ(heard(scene, 8).sliding, 0u);
}

// What was beyond the end a moment ago and not before came and left: a person at the corner of a wall.
TEST(SlidingRows, WhatLeftTheEndOfAWallDoesNotMoveTheWall) {
  test::ToyScene scene = beside(lorry(-4, 0));
  test::ToyBody person = test::toy_box({-4.3, 3.25, 0.3}, {0.25, 0.25, 1.6});
  person.velocity_0 = {-1, 0, 0};  // 0.05 m behind the rear end at first
  scene.world.push_back(person);
  EXPECT_EQ(heard(scene, 8).sliding, 0u);
}

// Where it was so many scans ago, behind where it is: at 1 m/s, as by chance, and at once from a place it had
// been at long ago.
TEST(SlidingRows, TheWayOfOneThingIsSteady) {
  const auto sliding = [](const std::vector<std::pair<int, double>>& behind_m) {
    std::vector<Then> then;
    for (const auto& [gap, m] : behind_m) then.push_back({gap, beside(lorry(-3.2 - m, 0)), 0});
    return heard(cast(beside(lorry(-3.2, 0))), then).sliding;
  };
  const std::size_t few = 100;  // near the ends other votes may make the same sum
  EXPECT_GT(sliding({{1, 0.1}, {2, 0.2}, {3, 0.3}, {4, 0.4}, {6, 0.6}, {8, 0.8}}), 10000u);
  EXPECT_LT(sliding({{1, 0}, {2, 0.5}, {3, 0.2}, {4, 0.7}, {6, 0.2}, {8, 0.4}}), few);
  EXPECT_LT(sliding({{1, 0}, {2, 0}, {3, 0.35}, {4, 0.35}, {6, 1.2}, {8, 1.2}}), few);
}

TEST(SlidingRows, TwoScansThatSayTheSameAreNeeded) {
  EXPECT_EQ(heard(beside(lorry(-4, 1)), 8, {4}).sliding, 0u);
  EXPECT_EQ(heard(beside(lorry(-4, 1)), 8, {3, 4}).sliding, 0u);  // none twice as far back as another
  EXPECT_GT(heard(beside(lorry(-4, 1)), 8, {4, 8}).sliding, 10000u);
}

// Two walls that meet at 45 degrees: lines go along one or the other.
TEST(RowLines, AreCutWhereARowBends) {
  const CompensatedScan scan = cast(standing({test::toy_box({10, 0, 0}, {0.5, 20, 10}),
                                              test::toy_box({6, 8, 0}, {0.5, 20, 10}, std::numbers::pi / 4)},
                                             "VLP-16"));
  const LocalPoints points = local_points(scan);
  RowLines lines(*scan.scan, points, {});
  std::size_t end = 0;
  while (end < points.points.size() && scan.scan->returns[end].laser == 0) ++end;
  for (std::size_t i = 0; i + 1 < end; i += 8) lines.add(i, std::min(i + 8, end - 1));
  lines.end();
  ASSERT_GE(lines.lines().size(), 2u);
  for (const auto& [first, last] : lines.lines()) {
    const Eigen::Vector3f way =
        points.points[static_cast<std::size_t>(last)] - points.points[static_cast<std::size_t>(first)];
    EXPECT_GT(way.norm(), 1.5F);
    const float slope = std::abs(way.x() / way.y());
    EXPECT_LT(std::min(slope, std::abs(slope - 1)), 0.1F) << way.transpose();
  }
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
