#include "detection/evidence/range_rate.hpp"

#include <algorithm>
#include <random>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "detection/evidence/collect_evidence.hpp"
#include "support/detection/standing_scene.hpp"
#include "support/local_points.hpp"

namespace mapless {
namespace MAPLESS_FILE {

using Offsets = std::vector<RangeOffset>;

constexpr float kStd_m = 0.04F;

/// Of a surface that recedes by `step_m` a scan, seen by rays that pass `aside_m` beside the point.
Offsets receding(float step_m, float aside_m = 0.01F) {
  Offsets offsets;
  for (const int gap : {12, 8, 6, 4, 3, 2, 1, -1})
    offsets.push_back({gap, step_m * static_cast<float>(gap), aside_m});
  return offsets;
}

bool moves(Offsets offsets, float slope = 0) { return moves_along_rays(offsets, kStd_m, slope); }

TEST(MovesAlongRays, WhatRecedesOrApproachesSteadily) {
  EXPECT_TRUE(moves(receding(0.05F)));
  EXPECT_TRUE(moves(receding(-0.05F)));
  EXPECT_FALSE(moves(receding(0)));
  EXPECT_FALSE(moves(receding(0.02F)));  // slopes and the grid of the rays feign as much
}

TEST(MovesAlongRays, NotWhatStandsUnderNoise) {
  const unsigned seed = 20;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937 random(seed);
  std::normal_distribution<float> noise(0, kStd_m / 2);
  int standing = 0, receding_found = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    Offsets still = receding(0), moving = receding(0.06F);
    for (RangeOffset& offset : still) offset.short_by_m += noise(random);
    for (RangeOffset& offset : moving) offset.short_by_m += noise(random);
    standing += moves(still) ? 1 : 0;
    receding_found += moves(moving) ? 1 : 0;
  }
  EXPECT_EQ(standing, 0);
  EXPECT_GT(receding_found, 1990);
}

TEST(MovesAlongRays, NotWhatHasLeapt) {
  Offsets offsets = receding(0);
  for (RangeOffset& offset : offsets) offset.short_by_m = offset.gap >= 3 ? 0.3F : 0;
  EXPECT_FALSE(moves(offsets));
}

TEST(MovesAlongRays, AnotherSurfaceDoesNotAgree) {
  Offsets offsets = receding(0.05F);
  offsets[2].short_by_m = 1.5F;
  ASSERT_TRUE(moves_along_rays(offsets, kStd_m, 0));
  for (const RangeOffset& offset : offsets) EXPECT_EQ(offset.agrees, &offset != &offsets[2]) << offset.gap;
}

TEST(MovesAlongRays, NotOnFewScans) {
  Offsets offsets = receding(0.2F);
  offsets.erase(offsets.begin(), offsets.end() - 3);
  EXPECT_FALSE(moves(offsets));
}

// A ray that passes 0.3 m aside of a surface that slants by 0.8 ends 0.24 m nearer or farther: that is 3.5
// standard deviations for the 0.05 m a scan over the root of the sum of squared gaps, 16.6.
TEST(MovesAlongRays, NotOnSlantingSurfaces) {
  EXPECT_TRUE(moves(receding(0.05F, 0.01F), 0.8F));
  EXPECT_FALSE(moves(receding(0.05F, 0.3F), 0.8F));
  EXPECT_FALSE(moves(receding(0.05F, 0.01F), 1.5F));
}

// A wall at 7 m that has receded by 0.035 m a scan is within the tolerance, 0.1 m, of where three scans saw
// it.
TEST(CollectEvidence, AWallThatRecedesSlowlyMoves) {
  const auto lowest_votes = [](double step_m) {
    const CompensatedScan query = test::cast(test::standing({test::wall_at(7)}));
    std::vector<RayImage> images;
    const std::vector<int> gaps = {6, 4, 3, 2, 1, -1};
    for (const int gap : gaps)
      images.emplace_back(test::cast(test::standing({test::wall_at(7 - step_m * gap)})));
    const auto votes = collect_evidence(*query.scan, test::local_points(query),
                                        test::references(images, gaps), RayImage(query), {});
    int lowest = 100;
    for (std::size_t i = 0; i < votes.size(); ++i) {
      if (test::is_ahead(query, i)) lowest = std::min(lowest, votes[i].total());
    }
    return lowest;
  };
  EXPECT_GE(lowest_votes(0.035), 12);  // two of each scan
  EXPECT_LT(lowest_votes(0), 0);
}

// A sensor that rises by 0.1 m/s sees its lowest ring wander outwards on a table top 1 m below, by 0.039 m
// a scan, which is 0.010 m beside the rays. No laser beside it meets the table, so no slope tells.
TEST(CollectEvidence, ARingThatWandersOutOfSightOfOthersDoesNotMove) {
  test::ToyScene scene = test::standing({test::toy_box({3.75, 0, -2}, {0.55, 0.3, 1})}, "VLP-16");
  Vector6d varpi = Vector6d::Zero();
  varpi.z() = -0.1;
  scene.trajectory = std::make_shared<test::SteadyTrajectory>(SE3(), varpi);
  constexpr int kScan = 12;
  const CompensatedScan query = test::cast(scene, kScan);
  std::vector<RayImage> images;
  const std::vector<int> gaps = {12, 8, 6, 4, 3, 2, 1, -1};
  for (const int gap : gaps) images.emplace_back(test::cast(scene, kScan - gap));
  const auto votes = collect_evidence(*query.scan, test::local_points(query), test::references(images, gaps),
                                      RayImage(query), {});
  EXPECT_GT(votes.size(), 30U);
  for (const PointEvidence& one : votes) EXPECT_LE(one.total(), 0);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
