#include "odometry/registration/motion_support.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace mapless {
namespace MAPLESS_FILE {

MotionSupport after(int scans, double weight, double ratio) {
  MotionSupport out;
  Degeneracy degeneracy;
  degeneracy.constraint_ratio = {ratio, 1, 1};
  for (int k = 0; k < scans; ++k) out.add(weight, degeneracy);
  return out;
}

// weight + 0.042 ln(ratio), limits 0.257 and, for the first 15 scans, 0.08 (docs/odometry.md).
double weight_for(double support, double ratio) { return support - 0.042 * std::log(ratio); }

TEST(MotionSupport, IsGoodBeforeTheFirstScan) { EXPECT_EQ(MotionSupport().state(), MotionState::good); }

TEST(MotionSupport, LittleIsDegenerateOnAYoungMapAndLostLater) {
  for (const double ratio : {0.001, 0.1}) {
    for (const int scans : {1, 14}) {
      EXPECT_EQ(after(scans, weight_for(0.26, ratio), ratio).state(), MotionState::good);
      EXPECT_EQ(after(scans, weight_for(0.25, ratio), ratio).state(), MotionState::degenerate);
      EXPECT_EQ(after(scans, weight_for(0.07, ratio), ratio).state(), MotionState::lost);
    }
    EXPECT_EQ(after(15, weight_for(0.26, ratio), ratio).state(), MotionState::good);
    EXPECT_EQ(after(15, weight_for(0.25, ratio), ratio).state(), MotionState::lost);
  }
}

TEST(MotionSupport, IsTheMeanOfTheLastFiveScans) {
  MotionSupport support = after(20, weight_for(0.3, 0.1), 0.1);
  Degeneracy degeneracy;
  degeneracy.constraint_ratio = {0.1, 1, 1};
  support.add(weight_for(0.1, 0.1), degeneracy);  // mean (4 0.3 + 0.1) / 5 = 0.26
  EXPECT_EQ(support.state(), MotionState::good);
  support.add(weight_for(0.1, 0.1), degeneracy);  // 0.22
  EXPECT_EQ(support.state(), MotionState::lost);
  for (int k = 0; k < 5; ++k) support.add(weight_for(0.3, 0.1), degeneracy);
  EXPECT_EQ(support.state(), MotionState::good);
}

// `edges` in each of the scans; the ratio makes the planes' support 0.2.
MotionState with_edges(int scans, double weight, double edges) {
  MotionSupport out;
  Degeneracy degeneracy;
  degeneracy.constraint_ratio = {std::exp((0.2 - weight) / 0.042), 1, 1};
  for (int k = 0; k < scans; ++k) {
    out.add(weight, degeneracy);
    EXPECT_TRUE(out.needs_edges());
    out.add_edges(edges);
  }
  return out.state();
}

TEST(MotionSupport, EdgesThatAgreeStandInForPlanesAtAnyAgeOfTheMap) {
  for (const int scans : {1, 4, 30}) {
    EXPECT_EQ(with_edges(scans, 0.36, 0.17), MotionState::good) << scans;
    EXPECT_NE(with_edges(scans, 0.36, 0.15), MotionState::good) << scans;
    EXPECT_NE(with_edges(scans, 0.34, 0.17), MotionState::good) << scans;  // few points agree
  }
  EXPECT_EQ(with_edges(30, 0.36, 0.15), MotionState::lost);
}

TEST(MotionSupport, EdgesDoNotReplaceAllSupport) {
  for (const int scans : {1, 30}) {
    MotionSupport support = after(scans, weight_for(0.07, 1e-5), 1e-5);
    support.add_edges(0.5);
    EXPECT_EQ(support.state(), MotionState::lost);
  }
}

// A fifth of the newest: (4 0.2 + 0.05) / 5 = 0.17, then 0.146.
TEST(MotionSupport, OneScanOfPoorEdgesIsNotALoss) {
  MotionSupport support = after(20, weight_for(0.2, 1e-4), 1e-4);
  Degeneracy degeneracy;
  degeneracy.constraint_ratio = {1e-4, 1, 1};
  support.add_edges(0.2);
  for (const MotionState expected : {MotionState::good, MotionState::lost}) {
    support.add(weight_for(0.2, 1e-4), degeneracy);
    support.add_edges(0.05);
    EXPECT_EQ(support.state(), expected);
  }
}

// An edge agreement of long ago says nothing about a later loss.
TEST(MotionSupport, EdgesCountWhileTheyAreNeeded) {
  MotionSupport support = after(20, weight_for(0.2, 1e-4), 1e-4);
  support.add_edges(0.4);
  EXPECT_EQ(support.state(), MotionState::good);
  Degeneracy degeneracy;
  degeneracy.constraint_ratio = {0.1, 1, 1};
  for (int k = 0; k < 5; ++k) support.add(weight_for(0.3, 0.1), degeneracy);
  EXPECT_FALSE(support.needs_edges());
  degeneracy.constraint_ratio[0] = 1e-4;
  for (int k = 0; k < 5; ++k) support.add(weight_for(0.2, 1e-4), degeneracy);
  EXPECT_TRUE(support.needs_edges());
  EXPECT_EQ(support.state(), MotionState::lost);
}

// A direction that no point constrains has the ratio 0.
TEST(MotionSupport, ARatioOfZeroIsFinite) {
  EXPECT_EQ(after(1, 0.257 + 0.042 * 11.6, 0).state(), MotionState::good);  // -ln(1e-5) = 11.51
  EXPECT_EQ(after(1, 0.257 + 0.042 * 11.4, 0).state(), MotionState::degenerate);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
