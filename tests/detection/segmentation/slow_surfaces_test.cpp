#include "detection/segmentation/slow_surfaces.hpp"

#include <cstddef>
#include <vector>

#include <gtest/gtest.h>

#include "support/detection/evidence_image.hpp"

namespace mapless {
namespace MAPLESS_FILE {

// Seven returns of one laser beside one another, all of which the scans before and after saw as a surface,
// and the middle one of which an older scan saw through.
class SlowSurfaces : public test::EvidenceImage {
 protected:
  SlowSurfaces() {
    for (int c = kFirst; c <= kLast; ++c) {
      PointEvidence& v = of(c);
      v.past = v.future = -1;
      v.surface_seen = v.surface_last = v.surface_next = true;
    }
    of(kMiddle).past = kSeenThroughVotes - 1;
    of(kMiddle).seen_through = true;
  }
  PointEvidence& of(int column) { return votes_[at(kLaser, column)]; }
  [[nodiscard]] std::vector<int> forgiven() {
    forgive_slow_surfaces(scan_, points_, parameters_, votes_);
    std::vector<int> columns;
    for (int c = kFirst; c <= kLast; ++c)
      if (of(c).may_be_slow) columns.push_back(c);
    return columns;
  }

  static constexpr int kLaser = 2, kFirst = 5, kMiddle = 8, kLast = 11;
};

// The window of 3 x 5 reaches two columns.
TEST_F(SlowSurfaces, AreForgivenWhereALinkedNeighbourWasSeenThrough) {
  EXPECT_EQ(forgiven(), (std::vector{6, 7, 8, 9, 10}));
  EXPECT_EQ(of(kMiddle).past, kSeenThroughVotes);
  EXPECT_EQ(of(kMiddle).future, 0);
  EXPECT_EQ(of(7).total(), 0);
  EXPECT_EQ(of(5).total(), -2);
}

TEST_F(SlowSurfaces, AreForgivenWhereWhatHidThemHasLeft) {
  of(kMiddle).seen_through = false;
  EXPECT_TRUE(forgiven().empty());
  of(kMiddle).occluder_left = true;
  EXPECT_EQ(forgiven(), (std::vector{6, 7, 8, 9, 10}));
}

TEST_F(SlowSurfaces, CountWhereAnOlderScanSawOne) {
  of(7).stood_before = true;
  EXPECT_EQ(forgiven(), (std::vector{6, 8, 9, 10}));
  EXPECT_EQ(of(7).total(), -2);
}

TEST_F(SlowSurfaces, CountWhereNeighboursAreNotLinked) {
  parameters_.link_m = parameters_.link_per_m = parameters_.link_spacings = 0;
  EXPECT_EQ(forgiven(), std::vector{kMiddle});
}

// The votes of other scans stay: the point was seen by the scan before alone, and one three back saw a
// surface.
TEST_F(SlowSurfaces, GiveBackWhatTheScansBesideTook) {
  of(9).surface_next = false;
  of(9).future = 0;
  of(9).past = -2;
  (void)forgiven();
  EXPECT_EQ(of(9).past, -1);
  EXPECT_EQ(of(9).future, 0);
}

TEST_F(SlowSurfaces, AreNoneWhereTheScansBesideSawNothing) {
  for (int c = kFirst; c <= kLast; ++c) of(c).surface_last = of(c).surface_next = false;
  EXPECT_TRUE(forgiven().empty());
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
