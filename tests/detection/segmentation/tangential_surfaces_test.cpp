#include <algorithm>

#include "support/detection/evidence_image.hpp"

namespace mapless {
namespace MAPLESS_FILE {

constexpr int kColumns = test::kSmallColumns;

/// The side of a bus, columns 6 to 15 of all lasers, at 5 m, in front of a wall at 10 m. A column is 15
/// degrees: 1.3 m on the bus, 2.6 m on the wall. On three lasers both ends have votes for motion, two columns
/// each, and the side between them has kTangentialVotes; on the first and the last laser all of the side has.
class BusSide : public test::EvidenceImage {
 protected:
  static constexpr int kFirst = 6, kLast = 15, kAll = 5 * 10, kFound = 3 * 4;
  BusSide() {
    parameters_.link_m = 2;
    parameters_.link_per_m = parameters_.link_spacings = 0;
    for (int l = 0; l < 5; ++l) {
      for (int c = 0; c < kColumns; ++c) {
        if (c < kFirst || c > kLast) {
          put(l, c, 10, -9);
        } else {
          set(l, c, l % 4 != 0 && (c < kFirst + 2 || c > kLast - 2) ? 3 : -4);
        }
      }
    }
  }
  void put(int laser, int column, float range_m, int votes) {
    LidarReturn& r = scan_.returns[at(laser, column)];
    r.position_v *= range_m / r.range_m;
    r.range_m = range_m;
    points_.points[at(laser, column)] = r.position_v;
    set(laser, column, votes);
  }
  // Half a metre from row to row, more than kBaseline_m.
  void stretch() {
    for (std::size_t i = 0; i < scan_.returns.size(); ++i)
      points_.points[i].z() = 0.5F * static_cast<float>(scan_.returns[i].laser);
  }
  [[nodiscard]] long found() const {
    const auto objects = grow().object;
    return std::count_if(objects.begin(), objects.end(), [](std::uint16_t object) { return object != 0; });
  }
};

TEST_F(BusSide, BelongsToTheEndsThatMove) {
  EXPECT_EQ(found(), kAll);
  EXPECT_EQ(grow().objects, 1);
  parameters_.grow = false;
  EXPECT_EQ(found(), kFound);
}

// In the first scans only the own vehicle is known to be static, and sides would extend over all else.
TEST_F(BusSide, IsNotEvaluatedWhereOnlyTheOwnVehicleIsKnownToBeStatic) {
  for (PointEvidence& v : votes_) v.own_vehicle = v.total() == -9;  // the wall
  EXPECT_EQ(found(), kFound);
}

// For one end that continues into static points there must be more than three in front of something farther.
TEST_F(BusSide, IsStaticIfItContinuesIntoStaticPoints) {
  put(0, kLast + 1, 5, -9);
  EXPECT_EQ(found(), kFound);  // three free ends, one that continues
  set(2, kLast - 1, -4);
  set(2, kLast, -4);
  EXPECT_EQ(found(), kAll);  // four free ends
}

// The row above is static, in line with those below.
TEST_F(BusSide, IsStaticIfItContinuesStraightAcrossRowsIntoStaticPoints) {
  for (int c = kFirst; c <= kLast; ++c) set(4, c, -9);
  stretch();
  EXPECT_EQ(found(), kFound);
  for (int c = kFirst; c <= kLast; ++c) put(4, c, 6, -9);  // not in line: a metre behind
  stretch();
  EXPECT_EQ(found(), kAll - 10);
}

// No scan observed the row above before. The side continues straight into both ends, as the ground would not.
TEST_F(BusSide, ContinuesIntoUnobservedPointsIfItContinuesStraightIntoMovingOnes) {
  for (int c = kFirst; c <= kLast; ++c) votes_[at(4, c)] = {0, -1, false, true, false, false, false};
  stretch();
  EXPECT_EQ(found(), kAll - 10);
  for (int l = 1; l < 4; ++l) {
    for (const int c : {kFirst, kFirst + 1, kLast - 1, kLast}) put(l, c, 4, 3);
  }
  stretch();
  EXPECT_EQ(found(), kFound);
}

// Something nearer occludes its ends.
TEST_F(BusSide, IsStaticIfNoEndIsVisible) {
  for (const int l : {0, 4}) {
    for (const int c : {kFirst - 1, kLast + 1}) put(l, c, 2, -9);
  }
  EXPECT_EQ(found(), kFound);
  put(4, kFirst - 1, 10, -9);
  EXPECT_EQ(found(), kAll);
}

TEST_F(BusSide, ExcludesPointsThatOnlyTheLaterScanObserved) {
  for (int c = 10; c < 12; ++c) votes_[at(0, c)] = {0, -1, false, true, false, false, false};
  EXPECT_EQ(found(), kAll - 2);
  for (int c = 10; c < 12; ++c) votes_[at(0, c)].seen_dynamic = true;
  EXPECT_EQ(found(), kAll);
}

// 44 candidates are at most eight times the six labelled points, 47 more than eight times three.
TEST_F(BusSide, IsAtMostEightTimesTheLabelledPoints) {
  for (int l = 1; l < 4; ++l) {
    for (int c = kFirst; c < kFirst + 2; ++c) set(l, c, -4);
  }
  EXPECT_EQ(found(), kAll);  // 44
  for (int l = 1; l < 4; ++l) set(l, kLast - 1, -4);
  EXPECT_EQ(found(), 3);  // 47
}

TEST_F(BusSide, IsStaticUntilSomePointIsKnownToBeStatic) {
  for (PointEvidence& v : votes_) v.past = std::max<std::int16_t>(v.past, -4);
  EXPECT_EQ(found(), kFound);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
