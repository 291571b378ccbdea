#include <algorithm>
#include <memory>
#include <vector>

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

// At rest, 0.3 m beside and 0.1 m above the sensor of the query scan, so that it sees nearly all of its wall.
test::ToyScene other_sensor(const test::ToyWorld& world) {
  test::ToyScene scene = standing(world);
  scene.trajectory = std::make_shared<test::SteadyTrajectory>(
      SE3(Eigen::Matrix3d::Identity(), Vector3d(0, -0.3, -0.1)), Vector6d::Zero());
  return scene;
}

RayImage saw(double wall_x) { return RayImage(cast(other_sensor({wall_at(wall_x)}))); }

struct Tally {
  std::size_t ahead = 0, seen_through = 0, surface_seen = 0, recently_free = 0;
  int least_past = 1000, most_past = -1000;
};

// Of a wall at 7 m, with a scan of its own sensor that could not see the place (4 m: hidden, too far before
// it to be of the same object), and scans of another.
Tally votes_of(const std::vector<ReferenceScan>& others) {
  const CompensatedScan query = cast(standing({wall_at(7)}));
  const RayImage own(query), hidden(cast(standing({wall_at(4)})));
  const auto votes =
      collect_evidence(*query.scan, local_points(query), {{&hidden, 2}}, own, {}, nullptr, others);
  Tally tally;
  for (std::size_t i = 0; i < votes.size(); ++i) {
    if (!is_ahead(query, i)) continue;
    ++tally.ahead;
    tally.seen_through += votes[i].seen_through ? 1 : 0;
    tally.surface_seen += votes[i].surface_seen ? 1 : 0;
    tally.recently_free += votes[i].recently_free ? 1 : 0;
    tally.least_past = std::min(tally.least_past, static_cast<int>(votes[i].past));
    tally.most_past = std::max(tally.most_past, static_cast<int>(votes[i].past));
  }
  return tally;
}

// Of the 64 lasers of the other sensor, 0.34 and 0.51 degrees apart, one passes within 0.07 m of nearly all
// points at 7 m: they are 0.04 and 0.06 m apart there.
TEST(OtherSensors, WhatTheySawThroughIsEvidence) {
  const RayImage farther = saw(10);
  const Tally none = votes_of({}), one = votes_of({{&farther, 2}}),
              two = votes_of({{&farther, 2}, {&farther, 8}});
  ASSERT_GT(none.ahead, 5000u);
  EXPECT_EQ(none.most_past, 0);
  EXPECT_EQ(none.seen_through, 0u);
  EXPECT_EQ(one.most_past, kSeenThroughVotes);
  EXPECT_EQ(one.least_past, 0);
  EXPECT_GT(one.seen_through, one.ahead * 9 / 10);
  EXPECT_EQ(one.recently_free, one.seen_through);
  EXPECT_EQ(two.most_past, 2 * kSeenThroughVotes);
}

TEST(OtherSensors, AnOldScanDoesNotShowThatAPlaceWasFreeAMomentAgo) {
  const RayImage farther = saw(10);
  const Tally old = votes_of({{&farther, 8}});
  EXPECT_GT(old.seen_through, old.ahead * 9 / 10);
  EXPECT_EQ(old.recently_free, 0u);
}

// Neither a surface nor an occluder of another sensor votes against a point or for it.
TEST(OtherSensors, TheirSurfacesAndOccludersAreNoEvidence) {
  const RayImage same = saw(7), nearer = saw(6);
  for (const RayImage* image : {&same, &nearer}) {
    const Tally tally = votes_of({{image, 2}, {image, 16}});
    EXPECT_EQ(tally.least_past, 0);
    EXPECT_EQ(tally.most_past, 0);
    EXPECT_EQ(tally.seen_through, 0u);
    EXPECT_EQ(tally.surface_seen, 0u);
  }
}

// 16 back the other sensor saw a surface (4 against), 2 back it saw through (4 for): it does not know. With
// one more scan that saw through, 4 are left.
TEST(OtherSensors, TheirSurfacesTakeBackWhatTheySawThrough) {
  const RayImage same = saw(7), farther = saw(10);
  EXPECT_EQ(votes_of({{&farther, 2}, {&same, 16}}).seen_through, 0u);
  const Tally more = votes_of({{&farther, 1}, {&farther, 2}, {&same, 16}});
  EXPECT_EQ(more.most_past, 2 * kSeenThroughVotes - kMaxSurfaceVotes);
  EXPECT_GT(more.seen_through, more.ahead * 8 / 10);
}

// The place was empty, and the rays of 16 lasers pass up to 0.12 m beside its points: those beyond 0.07 m
// tell nothing, since another sensor passes edges and gaps at other angles.
TEST(OtherSensors, ARayThatPassesBesideIsNoEvidence) {
  test::ToyScene sparse = other_sensor({wall_at(10)});
  sparse.model = std::make_shared<const LidarModel>(named_model("VLP-16"));
  const RayImage farther(cast(sparse));
  const Tally tally = votes_of({{&farther, 2}});
  EXPECT_GT(tally.seen_through, tally.ahead / 10);
  EXPECT_LT(tally.seen_through, tally.ahead * 3 / 4);
  EXPECT_EQ(tally.most_past, kSeenThroughVotes);
}

// What the own sensor saw as a surface for long is settled, whatever another saw.
TEST(OtherSensors, SettledPointsStayAsTheyAre) {
  const CompensatedScan query = cast(standing({wall_at(7)}));
  const RayImage own(query), farther = saw(10);
  const std::vector<ReferenceScan> surfaces = {{&own, 32}, {&own, 12}, {&own, 4}, {&own, 2}, {&own, 1}};
  const auto alone = collect_evidence(*query.scan, local_points(query), surfaces, own, {});
  EXPECT_EQ(collect_evidence(*query.scan, local_points(query), surfaces, own, {}, nullptr, {{&farther, 2}}),
            alone);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
