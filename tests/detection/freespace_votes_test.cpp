#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <numbers>
#include <utility>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "oracle/freespace_votes_oracle.hpp"
#include "support/local_points.hpp"
#include "support/toy_scene.hpp"
#include <mapless/detection/freespace_votes.hpp>

namespace mapless {
namespace MAPLESS_FILE {

using Eigen::Vector3d;
using test::local_points;

test::ToyBody wall_at(double x) { return test::toy_box({x + 0.5, 0, 0}, {0.5, 40, 40}); }

CompensatedScan cast(const test::ToyScene& scene, int number = 0) {
  return compensate(test::cast_scan(scene, number).scan, *scene.trajectory);
}

test::ToyScene standing(const test::ToyWorld& world, const char* sensor = "HDL-64E-S3") {
  test::ToyScene scene;
  scene.model = std::make_shared<const LidarModel>(named_model(sensor));
  scene.trajectory = std::make_shared<StationaryTrajectory>();
  scene.world = world;
  return scene;
}

/// Points well within all the walls, as no wall reaches round the sensor.
bool is_ahead(const CompensatedScan& scan, std::size_t i) {
  const Vector3d& p = scan.points_0[i];
  return std::abs(p.y()) < 0.5 * p.x();
}

/// A scan that is asked, and where it saw the wall.
struct WallThen {
  double x;
  int gap;
};

struct Expected {
  int earlier, later;
  bool seen_through, surface_seen, recently, vacated = false;
};

bool is(const PointVotes& v, const Expected& e) {
  return v.earlier == e.earlier && v.later == e.later && v.seen_through == e.seen_through &&
         v.surface_seen == e.surface_seen && v.recently == e.recently && v.vacated == e.vacated;
}

std::vector<AskedScan> asked(const std::vector<RayImage>& images, const std::vector<int>& gaps) {
  std::vector<AskedScan> all;
  for (std::size_t k = 0; k < images.size(); ++k) all.push_back({&images[k], gaps[k]});
  return all;
}

void expect_votes(const std::vector<WallThen>& then, const Expected& expected,
                  const VotingParameters& parameters = {}) {
  const CompensatedScan query = cast(standing({wall_at(7)}));
  std::vector<RayImage> images;
  std::vector<int> gaps;
  for (const WallThen& wall : then) {
    SCOPED_TRACE(testing::Message() << "at " << wall.x << " by gap " << wall.gap);
    images.emplace_back(cast(standing({wall_at(wall.x)})));
    gaps.push_back(wall.gap);
  }
  const auto votes =
      collect_votes(*query.scan, local_points(query), asked(images, gaps), RayImage(query), parameters);
  ASSERT_EQ(votes.size(), query.points_0.size());
  std::size_t ahead = 0, right = 0;
  for (std::size_t i = 0; i < votes.size(); ++i) {
    if (!is_ahead(query, i)) continue;
    ++ahead;
    right += is(votes[i], expected) ? 1 : 0;
  }
  EXPECT_GT(ahead, 5000u);
  EXPECT_EQ(right, ahead) << "wall at " << then.front().x << " by gap " << then.front().gap;
}

TEST(SurfaceVotes, GrowWithTheLogarithmOfTheGap) {
  const std::vector<std::pair<int, int>> expected = {{-8, 1}, {-1, 1}, {1, 1},  {2, 1},  {3, 1},  {4, 2},
                                                     {7, 2},  {8, 3},  {15, 3}, {16, 4}, {32, 4}, {100, 4}};
  for (const auto& [gap, votes] : expected) EXPECT_EQ(surface_votes(gap), votes) << "gap " << gap;
}

// A wall at 7 m: seen through by scans that saw it at 10 m (+4), a surface for one that saw it at 7 m (-1 to
// -4), hidden from one that saw it at 4 m, by something that was 3 m off.
TEST(CollectVotes, AddsUpWhatEveryScanSays) {
  expect_votes({{10, 2}, {4, 4}, {10, 8}, {7, -1}}, {8, -1, true, true, true});
  expect_votes({{7, 2}, {7, 4}, {10, 8}, {10, -1}}, {-1 - 2 + 4, 4, true, true, true});
  expect_votes({{4, 2}, {4, 4}, {4, 8}, {4, -1}}, {0, 0, false, false, false});
  expect_votes({{10, 2}, {12, 4}, {14, 8}}, {12, 0, true, false, true});
  expect_votes({{7, 2}, {7.05, 4}, {6.95, 8}, {7, 16}, {7, 32}, {7, -1}},
               {-1 - 2 - 3 - 4 - 4, -1, false, true, false});
  expect_votes({{10, -1}}, {0, 4, true, false, true});
  expect_votes({{7, -1}}, {0, -1, false, true, false});
}

// What a scan more than four off saw through may have come to rest since.
TEST(CollectVotes, SeenThroughLatelyIsByAScanWithinFour) {
  expect_votes({{7, 2}, {10, 4}}, {-1 + 4, 0, true, true, true});
  expect_votes({{7, 2}, {10, 5}}, {-1 + 4, 0, true, true, false});
  expect_votes({{7, 2}, {10, -4}}, {-1, 4, true, true, true});
  expect_votes({{7, 2}, {10, -5}}, {-1, 4, true, true, false});
}

TEST(CollectVotes, WhereAllAreFarOffTheNearestTellsWhatMovesNow) {
  expect_votes({{10, 8}, {7, 16}}, {4 - 4, 0, true, true, true});
  expect_votes({{7, 8}, {10, 16}}, {-3 + 4, 0, true, true, false});
  expect_votes({{7, 8}, {10, 16}, {10, -5}}, {-3 + 4, 4, true, true, true});
}

// Seen at 6 m before: what hid the wall's points was 1 m off, up to 1.3 m at the wall's ends, where scan and
// wall meet at an angle. The scan itself, at rest, sees through the place at 6 m.
TEST(CollectVotes, WhatHidAPointAndHasLeftCountsByHowFarOffItWas) {
  VotingParameters parameters;
  parameters.vacated_m = 1.4;
  expect_votes({{6, 2}, {6, 4}, {6, 8}, {6, -1}}, {6, 2, false, false, true, true}, parameters);
  expect_votes({{7, 2}, {6, 8}}, {-1 + 2, 0, false, true, false, true}, parameters);
  parameters.vacated_m = 0.99;
  expect_votes({{6, 2}, {6, 4}, {6, 8}, {6, -1}}, {0, 0, false, false, false}, parameters);
}

// Half a metre nearer a scan before, the thing that hid the wall would be half a metre farther off a scan
// later, if it were the wall: so it was something else. At 0.2 m in four scans it may be the wall: 0.05 to
// 0.07 m a scan are less than twice the tolerance, of 0.1 m.
TEST(CollectVotes, WhatLeftFastIsNotWhatTheNextScanStillSees) {
  expect_votes({{6.5, 1}, {7, -1}}, {0, -1, false, true, false});
  expect_votes({{6, 1}, {6, 2}, {6.5, 2}, {7, -1}}, {0, -1, false, true, false});
  expect_votes({{6.8, 4}, {7, -1}}, {2, -1, false, true, true, true});
  expect_votes({{6.5, 1}, {7.5, -1}}, {2, 4, true, false, true, true});
  expect_votes({{6.5, 1}, {6.5, 8}}, {4, 0, false, false, true, true});
}

// A wall seen where it stands now by scans 2 and 8 back, and found moving by both then: neither is a witness
// that it stands, and the one of a moment ago has it go on.
TEST(CollectVotes, WhatWasFoundMovingAMomentAgoGoesOn) {
  const CompensatedScan query = cast(standing({wall_at(7)}));
  RayImage image(query);
  const std::vector<AskedScan> asked = {{&image, 2}, {&image, 8}};
  const auto votes = [&] { return collect_votes(*query.scan, local_points(query), asked, image, {}); };
  for (const PointVotes& v : votes()) {
    EXPECT_TRUE(is(v, {-1 - 3, 0, false, true, false}));
    EXPECT_FALSE(v.moving_seen);
  }
  image.mark_dynamic(*query.scan, std::vector<std::uint16_t>(query.points_0.size(), 1));
  for (const PointVotes& v : votes()) {
    EXPECT_TRUE(is(v, {kMovingVotes, 0, false, true, false}));
    EXPECT_TRUE(v.moving_seen);
  }
}

test::ToyBody crate_at(double x) { return test::toy_box({x + 0.5, 0, 0}, {0.5, 1, 0.8}); }

/// Votes of a scan of `now`, at rest, from one scan of `then`, by range ahead.
std::vector<std::pair<double, PointVotes>> votes_of(const test::ToyWorld& now, const test::ToyWorld& then) {
  const CompensatedScan query = cast(standing(now));
  const RayImage before(cast(standing(then)));
  const auto votes = collect_votes(*query.scan, local_points(query), {{&before, 2}}, RayImage(query), {});
  std::vector<std::pair<double, PointVotes>> ahead;
  for (std::size_t i = 0; i < votes.size(); ++i) {
    if (is_ahead(query, i)) ahead.emplace_back(query.points_0[i].x(), votes[i]);
  }
  return ahead;
}

// A crate that recedes along the rays hid its present face all the while: from 8 m to 9 m it tells of itself,
// from 8 m to 10.5 m it may as well be something else that was uncovered.
TEST(CollectVotes, ACrateThatRecedesIsHeardByThePlaceItLeft) {
  for (const auto& [at, expected] : {std::pair{9.0, kVacatedVotes}, std::pair{10.5, 0}}) {
    int on_crate = 0;
    for (const auto& [x, v] : votes_of({wall_at(20), crate_at(at)}, {wall_at(20), crate_at(8)})) {
      if (x > 15) {
        EXPECT_LE(v.total(), 0);
        continue;
      }
      ++on_crate;
      EXPECT_EQ(v.earlier, expected);
      EXPECT_EQ(v.recently, expected > 0);
    }
    EXPECT_GT(on_crate, 300);
  }
}

TEST(CollectVotes, AWallUncoveredByWhatWasFarFromItDoesNotMove) {
  int uncovered = 0;
  for (const auto& [x, v] : votes_of({wall_at(9)}, {wall_at(9), crate_at(6)})) {
    uncovered += v.total() == 0 ? 1 : 0;
    EXPECT_LE(v.total(), 0);
    EXPECT_FALSE(v.seen_through || v.vacated);
  }
  EXPECT_GT(uncovered, 1000);
}

// The sensor goes 2 m on, past a pole 1.5 m before a wall: other parts of the wall are hidden than before, by
// a pole that has not left.
TEST(CollectVotes, WhatWasHiddenByAThingThatStaysDoesNotMove) {
  test::ToyScene scene =
      standing({test::toy_box({2, 7, 0}, {40, 0.5, 40}), test::toy_cylinder({2, 5, 0}, 0.3, 3)});
  scene.trajectory = test::drive(10, 0);
  const CompensatedScan query = cast(scene, 2);
  const RayImage before(cast(scene, 0));
  const auto votes = collect_votes(*query.scan, local_points(query), {{&before, 2}}, RayImage(query), {});
  int hidden = 0;
  for (std::size_t i = 0; i < votes.size(); ++i) {
    const Vector3d& p = query.points_0[i];
    if (p.y() < 6 || std::abs(p.x() - 2) > 4) continue;
    EXPECT_LE(votes[i].total(), 0) << p.transpose();
    hidden += votes[i].total() == 0 ? 1 : 0;
  }
  EXPECT_GT(hidden, 100);
}

// A ray that met nothing went to the maximum range and hid nothing: a sensor that comes nearer by 2 m sees
// things then that were a little beyond it.
TEST(CollectVotes, WhatComesWithinTheMaximumRangeDoesNotMove) {
  test::ToyScene scene = standing({});
  const double max_range = scene.model->max_range_m;
  scene.world = {test::toy_box({max_range + 1.5, 0, 0}, {0.5, 400, 40})};
  scene.trajectory = test::drive(10, 0);
  const CompensatedScan query = cast(scene, 2);
  const RayImage before(cast(scene, 0));
  ASSERT_GT(query.points_0.size(), 100u);
  for (const PointVotes& v :
       collect_votes(*query.scan, local_points(query), {{&before, 2}}, RayImage(query), {}))
    EXPECT_FALSE(v.seen_through || v.vacated);
}

test::ToyScene raised(test::ToyScene scene, double height) {
  scene.trajectory = std::make_shared<test::MovedTrajectory>(
      scene.trajectory, SE3(Eigen::Matrix3d::Identity(), {0, 0, -height}), Duration());
  return scene;
}

// A wall's points are on the beams of the scan that sees it; those of a sensor somewhat higher pass above
// them by its height, less by a thirtieth at 15 degrees. Sixteen lasers are 0.24 m apart there.
TEST(CollectVotes, ARayThatPassesByProvesLessThanOneThroughThePoint) {
  const CompensatedScan query = cast(standing({wall_at(7)}, "VLP-16"));
  const auto expect = [&](double height, const test::ToyWorld& then, int expected) {
    SCOPED_TRACE(testing::Message() << "higher by " << height << " m, " << then.size() << " bodies then");
    const RayImage before(cast(raised(standing(then, "VLP-16"), height)));
    const auto votes = collect_votes(*query.scan, local_points(query), {{&before, 8}}, RayImage(query), {});
    std::size_t ahead = 0;
    for (std::size_t i = 0; i < votes.size(); ++i) {
      const bool lowest = query.scan->returns[i].laser == 0;  // below it nothing is known
      if (lowest || !is_ahead(query, i)) continue;
      ++ahead;
      EXPECT_EQ(votes[i].total(), expected) << query.points_0[i].transpose();
      EXPECT_TRUE(votes[i].seen_through);
    }
    EXPECT_GT(ahead, 1000u);
  };
  for (const double height : {0.0, 0.03, 0.065}) expect(height, {wall_at(10)}, 4);
  for (const double height : {0.08, 0.12}) expect(height, {wall_at(10)}, 2);
  expect(0.12, {}, 4);  // where nothing is behind, there is no edge it could have passed by
}

bool same(const PointVotes& a, const PointVotes& b) {
  return is(a, {b.earlier, b.later, b.seen_through, b.surface_seen, b.recently, b.vacated});
}

struct Scans {
  CompensatedScan query;
  RayImage own = RayImage(query);
  std::vector<RayImage> images;
  std::vector<int> gaps;

  Scans(const test::ToyScene& scene, int number, const std::vector<int>& others)
      : query(cast(scene, number)) {
    for (const int k : others) {
      images.emplace_back(cast(scene, k));
      gaps.push_back(number - k);
    }
  }
  [[nodiscard]] std::vector<PointVotes> votes() const {
    return collect_votes(*query.scan, local_points(query), asked(images, gaps), own, {});
  }
  [[nodiscard]] std::vector<PointVotes> all_votes() const {
    return test::ask_every_point(*query.scan, local_points(query), asked(images, gaps), own, {});
  }
};

// In a room where nothing moves all points between two that stand do so too, of a row or of the rows above
// and below; what scans that could not see a place do not vote differs here and there.
TEST(CollectVotes, OfSmoothSurfacesLittleIsLostByAskingSomePoints) {
  const Scans room(test::toy_room("HDL-64E-S3", test::drive(1, 0.3)), 9, {7, 5, 1, 10});
  const auto votes = room.votes();
  const auto all = room.all_votes();
  std::size_t other = 0, lost = 0, won = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    other += same(votes[i], all[i]) ? 0 : 1;
    lost += votes[i].total() <= 0 && all[i].total() > 0 ? 1 : 0;
    won += votes[i].total() > 0 && all[i].total() <= 0 ? 1 : 0;
  }
  EXPECT_LE(other, all.size() / 12);
  EXPECT_LE(lost, all.size() / 2000);  // border effects, which one scan that saw through decides
  EXPECT_LE(won, all.size() / 3000);
}

// On the street: of what the votes call dynamic when every point is asked, next to nothing may be missed.
// What lies on the line between two points that move does so too, whatever a scan may say of it alone.
TEST(CollectVotes, OfWhatMovesLittleIsLostByAskingSomePoints) {
  const Scans street(test::toy_street("HDL-64E-S2"), 30, {28, 26, 22, 14, 31});
  const auto votes = street.votes();
  const auto all = street.all_votes();
  std::size_t moves = 0, lost = 0, won = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    moves += all[i].total() > 0 ? 1 : 0;
    lost += all[i].total() > 0 && votes[i].total() <= 0 ? 1 : 0;
    won += all[i].total() <= 0 && votes[i].total() > 0 ? 1 : 0;
  }
  EXPECT_GT(moves, 1000u);
  EXPECT_LE(lost, moves / 35);
  EXPECT_LE(won, moves / 30);
}

// A pole that was not there before, of the width of one to three firings: between two points of a wall that
// agree.
TEST(CollectVotes, AsksAboutAThinThingInFrontOfAWall) {
  for (const double radius : {0.01, 0.02, 0.03}) {
    SCOPED_TRACE(radius);
    const test::ToyBody pole = test::toy_cylinder({7, 0, 0}, radius, 3);
    const CompensatedScan query = cast(standing({wall_at(10), pole}));
    const RayImage before(cast(standing({wall_at(10)})));
    const auto votes = collect_votes(*query.scan, local_points(query), {{&before, 2}}, RayImage(query), {});
    int on_pole = 0;
    for (std::size_t i = 0; i < votes.size(); ++i) {
      if (!is_ahead(query, i)) continue;
      const bool pole_point = query.points_0[i].x() < 8;
      on_pole += pole_point ? 1 : 0;
      EXPECT_EQ(votes[i].total(), pole_point ? 4 : -1) << query.points_0[i].transpose();
    }
    EXPECT_GT(on_pole, 20);
  }
}

// A bar that one laser hits, or two: between rows of a wall that stands by the vote of a scan of long ago.
TEST(CollectVotes, AsksAboutAThinThingBetweenTwoLasers) {
  const RayImage before(cast(standing({wall_at(10)})));
  int on_bar = 0;
  for (double z = -0.6; z < 0; z += 0.043) {
    SCOPED_TRACE(z);
    const CompensatedScan query = cast(standing({wall_at(10), test::toy_box({7, 0, z}, {0.02, 1.5, 0.02})}));
    const auto votes = collect_votes(*query.scan, local_points(query), {{&before, 16}}, RayImage(query), {});
    for (std::size_t i = 0; i < votes.size(); ++i) {
      if (!is_ahead(query, i)) continue;
      const bool bar_point = query.points_0[i].x() < 8;
      on_bar += bar_point ? 1 : 0;
      EXPECT_EQ(votes[i].total(), bar_point ? 4 : -4) << query.points_0[i].transpose();
    }
  }
  EXPECT_GT(on_bar, 500);
}

TEST(CollectVotes, ThreadsDoNotMatter) {
  const Scans street(test::toy_street("VLP-16"), 30, {28, 26, 22, 14, 31});
  const auto reference = street.votes();
  for (const std::size_t threads : {1u, 3u}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    const auto votes = street.votes();
    EXPECT_TRUE(std::equal(votes.begin(), votes.end(), reference.begin(), reference.end(), same));
  }
}

// Single precision about an origin near the points: as good at the far end of a country.
TEST(CollectVotes, FarFromTheWorldsOriginNothingChanges) {
  test::ToyScene room = test::toy_room("HDL-64E-S3", test::drive(2, 0.5));
  const Scans here(room, 3, {1, 4});
  Vector6d xi;
  xi << 600e3, -5400e3, 120, 0.1, -0.2, 2;
  room.trajectory = std::make_shared<test::MovedTrajectory>(room.trajectory, SE3::exp(xi), Duration());
  Scans there = here;
  there.query = compensate(here.query.scan, *room.trajectory);
  const LocalPoints local = local_points(there.query);
  for (std::size_t i = 0; i < local.points.size(); i += 101)
    EXPECT_LT((local.origin_0 + local.points[i].cast<double>() - there.query.points_0[i]).norm(), 1e-5);
}

TEST(CollectVotes, OfAnEmptyScanThereAreNone) {
  const CompensatedScan query = cast(standing({}));
  const RayImage image(cast(standing({wall_at(10)})));
  EXPECT_TRUE(
      collect_votes(*query.scan, local_points(query), {{&image, 2}, {&image, -1}}, RayImage(query), {})
          .empty());
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
