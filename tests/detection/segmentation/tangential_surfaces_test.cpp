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
  static constexpr int kFirst = 6, kLast = 15, kAll = 5 * 10, kFound = 3 * 4, kLeft = 3 * 2;
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
  void show_left_end_only() {
    for (int l = 1; l < 4; ++l) {
      for (int c = kLast - 1; c <= kLast; ++c) set(l, c, -4);
    }
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

// The left end alone moves: it takes 7 places of the rim of 44 points, one side of their square, not two. The
// rim ends freely at seven others.
TEST_F(BusSide, IsStaticIfItContinuesIntoStaticPoints) {
  show_left_end_only();
  put(0, kLast + 1, 5, -9);
  EXPECT_EQ(found(), kAll);  // six free ends, one that continues
  put(4, kLast + 1, 5, -9);
  EXPECT_EQ(found(), kLeft);  // five and two
}

TEST_F(BusSide, IsStaticIfItContinuesAcrossRowsIntoStaticPoints) {
  for (int c = kFirst; c <= kLast; ++c) set(4, c, -9);
  EXPECT_EQ(found(), kFound);
  for (int c = kFirst; c <= kLast; ++c) put(4, c, 8, -9);  // not linked: three metres behind
  EXPECT_EQ(found(), kAll - 10);
}

// Ground seen by two rows beside a foot: it touches the object at few places.
TEST_F(BusSide, IsStaticIfTheObjectTakesLessThanOneSideOfIt) {
  show_left_end_only();
  EXPECT_EQ(found(), kAll);
  for (const int l : {0, 4}) {
    for (const int c : {kFirst, kFirst + 1}) put(l, c, 10, -9);
  }
  EXPECT_EQ(found(), kLeft);  // 3 places of the rim of 40 points
}

// Something nearer occludes its ends.
TEST_F(BusSide, IsStaticIfNoEndIsVisible) {
  show_left_end_only();
  for (int l = 0; l < 5; ++l) put(l, kLast + 1, 2, -9);
  for (const int l : {0, 4}) put(l, kFirst - 1, 2, -9);
  EXPECT_EQ(found(), kLeft);
  put(4, kFirst - 1, 10, -9);
  EXPECT_EQ(found(), kAll);
}

// Both ends take 14 places of the rim of 38 points: two sides of their square.
TEST_F(BusSide, NeedsNoVisibleEndBetweenTwoThatMove) {
  for (const int l : {0, 4}) {
    for (const int c : {kFirst - 1, kLast + 1}) put(l, c, 2, -9);
  }
  EXPECT_EQ(found(), kAll);
  for (const int l : {0, 4}) {
    for (const int c : {kFirst - 1, kLast + 1}) put(l, c, 5, -9);
  }
  EXPECT_EQ(found(), kAll);  // continues into four static points
  for (const int l : {0, 4}) put(l, kLast, 5, -9);
  EXPECT_EQ(found(), kFound);  // 12 places of the rim of 36 points, and four static ones
}

// Of its right half the first two rows were seen by the later scan alone, the others by none.
TEST_F(BusSide, GoesOnWhereTheSensorLooksForTheFirstTime) {
  show_left_end_only();
  for (int l = 0; l < 5; ++l) {
    for (int c = 11; c <= kLast; ++c)
      votes_[at(l, c)] = {.future = static_cast<std::int16_t>(l < 2 ? -1 : 0)};
  }
  EXPECT_EQ(found(), kAll);
}

// All of it is one object then, and each end by itself without.
TEST_F(BusSide, AddsNoVotes) {
  const int whole = grow().evidence.at(0).votes;
  parameters_.grow = false;
  const auto ends = grow().evidence;
  ASSERT_EQ(ends.size(), 2U);
  EXPECT_NEAR(whole, ends[0].votes + ends[1].votes, 1);
  EXPECT_GT(whole, 0);
}

// 44 candidates are at most eight times the six labelled points, 47 more than eight times three.
TEST_F(BusSide, IsAtMostEightTimesTheLabelledPoints) {
  for (int l = 1; l < 4; ++l) {
    for (int c = kFirst; c <= kLast; ++c) set(l, c, c == 10 || c == 11 ? 3 : -4);
  }
  EXPECT_EQ(found(), kAll);  // 44
  for (int l = 1; l < 4; ++l) set(l, 11, -4);
  EXPECT_EQ(found(), 3);  // 47, 8 places of whose rim are at the object
}

TEST_F(BusSide, IsStaticUntilSomePointIsKnownToBeStatic) {
  for (PointEvidence& v : votes_) v.past = std::max<std::int16_t>(v.past, -4);
  EXPECT_EQ(found(), kFound);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
