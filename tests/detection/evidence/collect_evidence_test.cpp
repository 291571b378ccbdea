#include "detection/evidence/collect_evidence.hpp"

#include <cmath>
#include <map>
#include <memory>
#include <numbers>
#include <utility>

#include <gtest/gtest.h>

#include "support/detection/standing_scene.hpp"
#include "support/local_points.hpp"

namespace mapless {
namespace MAPLESS_FILE {

using Eigen::Vector3d;
using test::cast;
using test::is_ahead;
using test::local_points;
using test::references;
using test::standing;
using test::wall_at;

/// A reference scan, and where the wall was then.
struct WallThen {
  double x;
  int gap;
};

struct Expected {
  int past, future;
  bool seen_through, surface_seen, recently_free, occluder_left = false;
};

bool is(const PointEvidence& v, const Expected& e) {
  return v.past == e.past && v.future == e.future && v.seen_through == e.seen_through &&
         v.surface_seen == e.surface_seen && v.recently_free == e.recently_free &&
         v.occluder_left == e.occluder_left;
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
  const auto votes = collect_evidence(*query.scan, local_points(query), references(images, gaps),
                                      RayImage(query), parameters);
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
TEST(CollectEvidence, AddsUpTheVotesOfEveryScan) {
  expect_votes({{10, 2}, {4, 4}, {10, 8}, {7, -1}}, {8, -1, true, true, true});
  expect_votes({{7, 2}, {7, 4}, {10, 8}, {10, -1}}, {-1 - 2 + 4, 4, true, true, true});
  expect_votes({{4, 2}, {4, 4}, {4, 8}, {4, -1}}, {0, 0, false, false, false});
  expect_votes({{10, 2}, {12, 4}, {14, 8}}, {12, 0, true, false, true});
  expect_votes({{7, 2}, {7.05, 4}, {6.95, 8}, {7, 16}, {7, 32}, {7, -1}},
               {-1 - 2 - 3 - 4 - 4, -1, false, true, false});
  expect_votes({{10, -1}}, {0, 4, true, false, true});
  expect_votes({{7, -1}}, {0, -1, false, true, false});
}

// A wall that came between 64 and 32 scans ago is static: the scan before it came is not queried, and counts
// as if it had seen it. Where the wall came later, that scan counts. The order does not depend on the gap of
// the later scan.
TEST(CollectEvidence, AWallOfThirtyTwoScansIsStaticWhateverWasThereBefore) {
  for (const auto& [later, votes] : {std::pair{-1, -1}, std::pair{-40, -4}}) {
    expect_votes({{10, 64}, {7, 32}, {7, 12}, {7, 4}, {7, later}},
                 {-4 - 4 - 3 - 2, votes, false, true, false});
    expect_votes({{10, 64}, {10, 32}, {7, 12}, {7, 4}, {7, later}},
                 {4 + 4 - 3 - 2, votes, true, true, false});
  }
}

// Once six scans were queried, -6 is enough: a wall that was hidden from four of them, and that three others
// saw, was there 64 scans ago. Of three scans alone -6 is not.
TEST(CollectEvidence, FewerVotesSettleAPointOnceManyScansWereQueried) {
  expect_votes({{10, 64}, {4, 32}, {4, 24}, {4, 16}, {4, 12}, {7, 8}, {7, 4}, {7, 2}},
               {-4 - 3 - 2 - 1, 0, false, true, false});
  expect_votes({{10, 64}, {7, 8}, {7, 4}, {7, 2}}, {4 - 3 - 2 - 1, 0, true, true, false});
}

// An object seen through by a scan more than four away may have come to rest since.
TEST(CollectEvidence, RecentlyFreeIsByAScanWithinFour) {
  expect_votes({{7, 2}, {10, 4}}, {-1 + 4, 0, true, true, true});
  expect_votes({{7, 2}, {10, 5}}, {-1 + 4, 0, true, true, false});
  expect_votes({{7, 2}, {10, -4}}, {-1, 4, true, true, true});
  expect_votes({{7, 2}, {10, -5}}, {-1, 4, true, true, false});
}

TEST(CollectEvidence, WhereAllScansAreFarTheNearestIsRecent) {
  expect_votes({{10, 8}, {7, 16}}, {4 - 4, 0, true, true, true});
  expect_votes({{7, 8}, {10, 16}}, {-3 + 4, 0, true, true, false});
  expect_votes({{7, 8}, {10, 16}, {10, -5}}, {-3 + 4, 4, true, true, true});
}

// Seen at 6 m before: the occluder of the wall's points was 1 m off, up to 1.3 m at the wall's ends, where
// ray and wall meet at an angle. The scan itself, at rest, sees through the place at 6 m.
TEST(CollectEvidence, ADepartedOccluderCountsWithinItsDistance) {
  VotingParameters parameters;
  parameters.max_occluder_distance_m = 1.4;
  expect_votes({{6, 2}, {6, 4}, {6, 8}, {6, -1}}, {6, 2, false, false, true, true}, parameters);
  expect_votes({{7, 2}, {6, 8}}, {-1 + 2, 0, false, true, false, true}, parameters);
  expect_votes({{6, 2}, {6, -1}, {6, -3}}, {2, 2, false, false, true, true}, parameters);
  parameters.max_occluder_distance_m = 0.99;
  expect_votes({{6, 2}, {6, 4}, {6, 8}, {6, -1}}, {0, 0, false, false, false}, parameters);
}

// Half a metre nearer a scan before, the thing that hid the wall would be half a metre farther off a scan
// later, if it were the wall: so it was something else. At 0.18 m in four scans it may be the wall: 0.05 to
// 0.06 m a scan are no more than noise. So it may at 0.5 m in four scans, 0.13 to 0.16 m a scan, where the
// later scan sees it 0.05 m farther, but not where that sees it at its place.
TEST(CollectEvidence, AFastDepartureContradictsASurfaceInTheNextScan) {
  expect_votes({{6.5, 1}, {7, -1}}, {0, -1, false, true, false});
  expect_votes({{6, 1}, {6, 2}, {6.5, 2}, {7, -1}}, {0, -1, false, true, false});
  expect_votes({{6.82, 4}, {7.01, -1}}, {2, -1, false, true, true, true});
  expect_votes({{6.5, 4}, {7.05, -1}}, {2, -1, false, true, true, true});
  expect_votes({{6.5, 4}, {7, -1}}, {0, -1, false, true, false});
  expect_votes({{6.5, 1}, {7.5, -1}}, {2, 4, true, false, true, true});
  expect_votes({{6.5, 1}, {6.5, 8}}, {4, 0, false, false, true, true});
}

// Hidden for long by something that stood half a metre before it, and left a scan before: what has just
// uncovered the wall is not the wall, so that half a metre in eight scans, which alone would be slow enough,
// is not either. Where that left first, and something else came, stood nearer and left, the later one counts.
TEST(CollectEvidence, WhatHidAPointBeforeItWasUncoveredTellsNothing) {
  expect_votes({{6.82, 8}, {7, -1}}, {2, -1, false, true, false, true});
  expect_votes({{6.5, 1}, {6.82, 8}, {7, -1}}, {0, -1, false, true, false});
  expect_votes({{6.82, 4}, {6, 8}, {7, -1}}, {2, -1, false, true, true, true});
}

// A wall seen at its present place by scans 2 and 8 back, and found dynamic in both: neither votes against
// it, and the recent one votes for it.
TEST(CollectEvidence, ASurfaceFoundDynamicDoesNotVoteAgainst) {
  const CompensatedScan query = cast(standing({wall_at(7)}));
  RayImage image(query);
  const std::vector<ReferenceScan> scans = {{&image, 2}, {&image, 8}};
  const auto votes = [&] { return collect_evidence(*query.scan, local_points(query), scans, image, {}); };
  for (const PointEvidence& v : votes()) {
    EXPECT_TRUE(is(v, {-1 - 3, 0, false, true, false}));
    EXPECT_FALSE(v.seen_dynamic);
  }
  image.mark_dynamic(*query.scan, std::vector<std::uint16_t>(query.points_0.size(), 1));
  for (const PointEvidence& v : votes()) {
    EXPECT_TRUE(is(v, {kSeenDynamicVotes, 0, false, true, false}));
    EXPECT_TRUE(v.seen_dynamic);
  }
}

// A surface seen by a scan more than four before stood there; what a recent scan saw may have come since, and
// what was found dynamic did not stand.
TEST(CollectEvidence, WhatAnEarlierScanSawStoodThere) {
  const CompensatedScan query = cast(standing({wall_at(7)}));
  const auto stood_before = [&](int gap, bool dynamic) {
    RayImage image(query);
    if (dynamic) image.mark_dynamic(*query.scan, std::vector<std::uint16_t>(query.points_0.size(), 1));
    const RayImage recent(query);
    const auto votes = collect_evidence(*query.scan, local_points(query), {{&recent, 1}, {&image, gap}},
                                        RayImage(query), {});
    const auto stood =
        std::count_if(votes.begin(), votes.end(), [](const auto& v) { return v.stood_before; });
    EXPECT_TRUE(stood == 0 || static_cast<std::size_t>(stood) == votes.size());
    return stood != 0;
  };
  EXPECT_TRUE(stood_before(5, false));
  EXPECT_FALSE(stood_before(4, false));
  EXPECT_FALSE(stood_before(5, true));
  EXPECT_FALSE(stood_before(-4, false));
}

// In a turn of a fifth of a second a slow thing moves on.
TEST(CollectEvidence, NamesTheSurfacesThatTheScansBesideSaw) {
  const CompensatedScan query = cast(standing({wall_at(7)}));
  LidarScan scan = *query.scan;
  const auto all_seen = [&](int gap, bool dynamic, bool last, bool next) {
    RayImage image(query);
    if (dynamic) image.mark_dynamic(*query.scan, std::vector<std::uint16_t>(query.points_0.size(), 1));
    for (const PointEvidence& v :
         collect_evidence(scan, local_points(query), {{&image, gap}}, RayImage(query), {})) {
      EXPECT_EQ(v.surface_last, last) << gap;
      EXPECT_EQ(v.surface_next, next) << gap;
    }
  };
  all_seen(1, false, true, false);
  all_seen(-1, false, false, true);
  all_seen(2, false, false, false);
  all_seen(1, true, false, false);
  scan.column_period = Duration::from_nanoseconds(2 * scan.column_period.nanoseconds());
  all_seen(1, false, false, false);
  all_seen(-1, false, false, false);
}

test::ToyBody crate_at(double x) { return test::toy_box({x + 0.5, 0, 0}, {0.5, 1, 0.8}); }

/// Votes of a scan of `now`, at rest, from one scan of `then`, by range ahead.
std::vector<std::pair<double, PointEvidence>> votes_of(const test::ToyWorld& now,
                                                       const test::ToyWorld& then) {
  const CompensatedScan query = cast(standing(now));
  const RayImage before(cast(standing(then)));
  const auto votes = collect_evidence(*query.scan, local_points(query), {{&before, 2}}, RayImage(query), {});
  std::vector<std::pair<double, PointEvidence>> ahead;
  for (std::size_t i = 0; i < votes.size(); ++i) {
    if (is_ahead(query, i)) ahead.emplace_back(query.points_0[i].x(), votes[i]);
  }
  return ahead;
}

// A crate that recedes along the rays hid its present face all the while: from 8 m to 9 m its old place is
// evidence, from 8 m to 10.5 m it may as well be something else that was uncovered.
TEST(CollectEvidence, ARecedingCrateHasTheEvidenceOfThePlaceItLeft) {
  for (const auto& [at, expected] : {std::pair{9.0, kOccluderLeftVotes}, std::pair{10.5, 0}}) {
    int on_crate = 0;
    for (const auto& [x, v] : votes_of({wall_at(20), crate_at(at)}, {wall_at(20), crate_at(8)})) {
      if (x > 15) {
        EXPECT_LE(v.total(), 0);
        continue;
      }
      ++on_crate;
      EXPECT_EQ(v.past, expected);
      EXPECT_EQ(v.recently_free, expected > 0);
    }
    EXPECT_GT(on_crate, 300);
  }
}

TEST(CollectEvidence, AWallUncoveredByADistantOccluderIsStatic) {
  int uncovered = 0;
  for (const auto& [x, v] : votes_of({wall_at(9)}, {wall_at(9), crate_at(6)})) {
    uncovered += v.total() == 0 ? 1 : 0;
    EXPECT_LE(v.total(), 0);
    EXPECT_FALSE(v.seen_through || v.occluder_left);
  }
  EXPECT_GT(uncovered, 1000);
}

// The sensor goes 2 m on, past a pole 1.5 m before a wall: other parts of the wall are hidden than before, by
// a pole that has not left.
TEST(CollectEvidence, PointsHiddenByAStaticOccluderAreStatic) {
  test::ToyScene scene =
      standing({test::toy_box({2, 7, 0}, {40, 0.5, 40}), test::toy_cylinder({2, 5, 0}, 0.3, 3)});
  scene.trajectory = test::drive(10, 0);
  const CompensatedScan query = cast(scene, 2);
  const RayImage before(cast(scene, 0));
  const auto votes = collect_evidence(*query.scan, local_points(query), {{&before, 2}}, RayImage(query), {});
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
TEST(CollectEvidence, PointsThatComeWithinTheMaximumRangeAreStatic) {
  test::ToyScene scene = standing({});
  const double max_range = scene.model->max_range_m;
  scene.world = {test::toy_box({max_range + 1.5, 0, 0}, {0.5, 400, 40})};
  scene.trajectory = test::drive(10, 0);
  const CompensatedScan query = cast(scene, 2);
  const RayImage before(cast(scene, 0));
  ASSERT_GT(query.points_0.size(), 100u);
  for (const PointEvidence& v :
       collect_evidence(*query.scan, local_points(query), {{&before, 2}}, RayImage(query), {}))
    EXPECT_FALSE(v.seen_through || v.occluder_left);
}

test::ToyScene raised(test::ToyScene scene, double height) {
  scene.trajectory = std::make_shared<test::MovedTrajectory>(
      scene.trajectory, SE3(Eigen::Matrix3d::Identity(), {0, 0, -height}), Duration());
  return scene;
}

// A wall's points are on the beams of the scan that sees it; those of a sensor somewhat higher pass above
// them by its height, less by a thirtieth at 15 degrees. Sixteen lasers are 0.24 m apart there.
TEST(CollectEvidence, ARayBesideThePointCountsHalf) {
  const CompensatedScan query = cast(standing({wall_at(7)}, "VLP-16"));
  const auto expect = [&](double height, const test::ToyWorld& then, int expected) {
    SCOPED_TRACE(testing::Message() << "higher by " << height << " m, " << then.size() << " bodies then");
    const RayImage before(cast(raised(standing(then, "VLP-16"), height)));
    const auto votes =
        collect_evidence(*query.scan, local_points(query), {{&before, 8}}, RayImage(query), {});
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

// A pole 7 m ahead that stood 0.17 m to the left: a degree there is 0.12 m. From points of the pole whose
// nearest edge of its former self is 0.5 to 1 degrees aside the ray counts half, as between two leaves.
TEST(CollectEvidence, ARayBesideASurfaceCountsHalf) {
  const auto pole_at = [](double left_m) {
    return standing({test::toy_cylinder({7, left_m, 0}, 0.05, 5), wall_at(10)}, "VLP-16");
  };
  const CompensatedScan query = cast(pole_at(0));
  const RayImage before(cast(pole_at(0.17)));
  const auto votes = collect_evidence(*query.scan, local_points(query), {{&before, 8}}, RayImage(query), {});
  std::map<int, int> points;  // with so many votes
  for (std::size_t i = 0; i < votes.size(); ++i) {
    const Eigen::Vector3d& p = query.points_0[i];
    if (query.scan->returns[i].laser == 0 || p.x() > 8 || p.x() < 6 || std::abs(p.y()) > 0.1) continue;
    const double aside_deg = (std::atan2(0.12, 7) - std::atan2(p.y(), p.x())) * 180 / std::numbers::pi;
    if (std::abs(aside_deg - 1) < 0.1 || aside_deg < 0.5) continue;  // a column is 0.2 degrees
    EXPECT_EQ(votes[i].total(), aside_deg < 1 ? 2 : 4) << p.transpose();
    ++points[votes[i].total()];
  }
  EXPECT_GT(points[2], 10);
  EXPECT_GT(points[4], 10);
}

// Single precision about an origin near the points: as good at the far end of a country.
TEST(CollectEvidence, FarFromTheWorldsOriginNothingChanges) {
  test::ToyScene room = test::toy_room("HDL-64E-S3", test::drive(2, 0.5));
  Vector6d xi;
  xi << 600e3, -5400e3, 120, 0.1, -0.2, 2;
  room.trajectory = std::make_shared<test::MovedTrajectory>(room.trajectory, SE3::exp(xi), Duration());
  const CompensatedScan there = cast(room, 3);
  const LocalPoints local = local_points(there);
  for (std::size_t i = 0; i < local.points.size(); i += 101)
    EXPECT_LT((local.origin_0 + local.points[i].cast<double>() - there.points_0[i]).norm(), 1e-5);
}

TEST(CollectEvidence, OfAnEmptyScanThereAreNone) {
  const CompensatedScan query = cast(standing({}));
  const RayImage image(cast(standing({wall_at(10)})));
  EXPECT_TRUE(
      collect_evidence(*query.scan, local_points(query), {{&image, 2}, {&image, -1}}, RayImage(query), {})
          .empty());
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
