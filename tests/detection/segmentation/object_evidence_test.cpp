#include "detection/segmentation/object_evidence.hpp"

#include <cmath>
#include <cstdint>
#include <numeric>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "support/detection/evidence_image.hpp"
#include "support/small_scan.hpp"

namespace mapless {
namespace MAPLESS_FILE {

// Five lasers and 24 columns, whose columns are farther apart than the lasers: every point has rays of its
// own.
class RaysPastAnObject : public testing::Test {
 protected:
  // Of the point with index i, a ray of one scan went on `aside_m` beside it.
  void pass(std::size_t i, double aside_m) {
    PointEvidence& v = votes_[i];
    v.seen_through = true;
    if (aside_m <= static_cast<double>(kSeenThroughWithin_m)) {
      ++v.rays_through;
    } else {
      ++v.rays_beside;
      v.beside_m += static_cast<float>(aside_m);
    }
  }
  [[nodiscard]] double log_odds() const {
    std::vector<std::int32_t> object(votes_.size());
    std::iota(object.begin(), object.end(), 0);
    return ObjectEvidenceCollector(scan_, points_, votes_, 1000).collect(object).log_odds;
  }

  LidarScan scan_ = test::small_scan({0, 0, 0, 0, 0});
  LocalPoints points_ = test::points_of(scan_);
  std::vector<PointEvidence> votes_ = std::vector<PointEvidence>(scan_.returns.size());
  std::mt19937 random_{7};
};

// Of 120 rays at up to 0.35 m a fifth, 24, pass within 0.07 m: as many as the 96 others let expect. Of two
// Poisson distributions of mean 24 and .3 x 24 = 7.2, the former is e^(24 ln(1 / .3) - 16.8) = e^12 as
// likely.
TEST_F(RaysPastAnObject, AtAnyDistanceAreThoseOfAMover) {
  for (std::size_t i = 0; i < votes_.size(); ++i)  // each distance once, in every row
    pass(i, 0.35 * (static_cast<double>(i * 37 % 120) + 0.5) / 120);
  EXPECT_NEAR(log_odds(), 12, 1.5);
}

TEST_F(RaysPastAnObject, ThatKeepBesideItAreThoseOfAThinThing) {
  std::uniform_real_distribution<double> aside(0.14, 0.35);
  for (std::size_t i = 0; i < votes_.size(); ++i) pass(i, aside(random_));
  EXPECT_NEAR(log_odds(), -0.7 * 120 * 0.07 / (2 * (0.245 - 0.07)), 1.5);
}

TEST_F(RaysPastAnObject, FewTellNothing) {
  EXPECT_EQ(log_odds(), 0);
  for (std::size_t i = 0; i < 3; ++i) pass(i, 0.3);
  EXPECT_GT(log_odds(), -0.5);
}

// A sensor that stands has the same rays beside the same points in every scan.
TEST_F(RaysPastAnObject, OfManyScansAlikeCountOnce) {
  for (std::size_t i = 0; i < votes_.size(); ++i) pass(i, i % 8 == 0 ? 0.05 : 0.3);
  const double once = log_odds();
  for (int scan = 1; scan < 8; ++scan) {
    for (std::size_t i = 0; i < votes_.size(); ++i) pass(i, i % 8 == 0 ? 0.05 : 0.3);
  }
  EXPECT_NEAR(log_odds(), once, 1e-3);
}

// Points of two rows, along x and `across_m` apart, of which a scan saw a surface at the first.
class PointsOnALine : public testing::Test {
 protected:
  [[nodiscard]] ObjectEvidence collect(std::size_t count, float step_m, float across_m,
                                       bool surface_seen = true) {
    std::vector<std::int32_t> object(count);
    std::iota(object.begin(), object.end(), 0);
    for (std::size_t i = 0; i < count; ++i)
      points_.points[i] = {100 + step_m * static_cast<float>(i), i % 2 == 0 ? across_m : 0, 3};
    votes_.front().surface_seen = surface_seen;
    return ObjectEvidenceCollector(scan_, points_, votes_, 1000).collect(object);
  }

  LidarScan scan_ = test::small_scan({0, 0});
  LocalPoints points_ = test::points_of(scan_);
  std::vector<PointEvidence> votes_ = std::vector<PointEvidence>(scan_.returns.size());
};

// n points at equal steps have a standard deviation of sqrt((n^2 - 1) / 12) steps; two rows, of half their
// distance. Of 40 at 0.05 m: 0.577 m, a tenth of which is half of 0.115 m.
TEST_F(PointsOnALine, AreTenTimesAsLongAsBroad) {
  const ObjectEvidence line = collect(40, 0.05F, 0.11F);
  EXPECT_NEAR(std::abs(line.line_0.x()), 1, 0.01);
  EXPECT_EQ(line.body, Body::line);
  const ObjectEvidence broad = collect(40, 0.05F, 0.12F);
  EXPECT_TRUE(broad.line_0.isZero());
  EXPECT_EQ(broad.body, Body::unclear);
}

// Of ten: 2.87 steps, 0.1 m at steps of 0.0348 m.
TEST_F(PointsOnALine, AreSpreadByATenthOfAMetre) {
  EXPECT_FALSE(collect(10, 0.035F, 0).line_0.isZero());
  EXPECT_TRUE(collect(10, 0.034F, 0).line_0.isZero());
}

TEST_F(PointsOnALine, AreThree) {
  EXPECT_FALSE(collect(3, 1, 0).line_0.isZero());
  EXPECT_TRUE(collect(2, 1, 0).line_0.isZero());
}

// A bird in the sky is a line, too, where rays never met anything before.
TEST_F(PointsOnALine, AreNoneWhereNoScanSawASurface) {
  EXPECT_TRUE(collect(40, 0.05F, 0, false).line_0.isZero());
}

class VotesOfAnObject : public test::EvidenceImage {};

// Two rows of 40 and 20 votes: half of a row where a surface was seen.
TEST_F(VotesOfAnObject, ContradictedVotesCountHalf) {
  parameters_.grow = false;
  for (int c = 2; c < 6; ++c) set(0, c, 10);
  for (int c = 2; c < 6; ++c) set(1, c, 5);
  const auto seen = [&](bool below, bool above) {
    for (int c = 2; c < 6; ++c) {
      votes_[at(0, c)].surface_seen = below;
      votes_[at(1, c)].surface_seen = above;
    }
    return grow().evidence.at(0).votes;
  };
  EXPECT_EQ(seen(false, false), 60);
  EXPECT_EQ(seen(true, false), 40);
  EXPECT_EQ(seen(false, true), 50);
  EXPECT_EQ(seen(true, true), 30);
}

// A row of 40 votes counts 26, or half of that; the one of 20 counts in full.
TEST_F(VotesOfAnObject, OneRowCountsAtMostMinEvidence) {
  parameters_.grow = false;
  parameters_.min_evidence = 26;
  for (int c = 2; c < 6; ++c) set(0, c, 10);
  for (int c = 2; c < 6; ++c) set(1, c, 5);
  for (int c = 2; c < 6; ++c) votes_[at(0, c)].surface_seen = votes_[at(1, c)].surface_seen = false;
  EXPECT_EQ(grow().evidence.at(0).votes, 46);
  for (int c = 2; c < 6; ++c) votes_[at(0, c)].surface_seen = true;
  EXPECT_EQ(grow().evidence.at(0).votes, 33);
}

// At 60 degrees firings are half as far apart, and 40 votes count 20.
TEST_F(VotesOfAnObject, PointsOfABeamThatRisesCountLess) {
  parameters_.grow = false;
  for (int c = 2; c < 6; ++c) set(0, c, 10);
  test::raise_by_60_degrees(scan_);
  EXPECT_EQ(grow().evidence.at(0).votes, 20);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
