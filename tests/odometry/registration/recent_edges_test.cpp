#include "odometry/registration/recent_edges.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace mapless {
namespace MAPLESS_FILE {

using Eigen::Vector3d;
using Points = std::vector<Vector3d>;

// Far apart: no two lie within the reach of an edge of each other.
Points edges_in_a_hall(int count = 100) {
  Points out;
  for (int i = 0; i < count; ++i) out.emplace_back(2.0 * (i % 10), 2.0 * (i / 10), 0.37 * (i % 7));
  return out;
}

Points moved(Points points, const Vector3d& by) {
  for (Vector3d& p : points) p += by;
  return points;
}

// Five scans, each `step` off the one before. The first `still` edges are where the estimate expects them.
RecentEdges drifting(const Vector3d& step, int still = 0, int edges = 100) {
  RecentEdges out;
  for (int scan = 0; scan < 5; ++scan) {
    Points points = moved(edges_in_a_hall(edges), scan * step);
    const Points right = edges_in_a_hall(still);
    std::copy(right.begin(), right.end(), points.begin());
    out.add(std::move(points));
  }
  return out;
}

const Vector3d kAlong = Vector3d::UnitX(), kAcross = Vector3d::UnitY();

TEST(RecentEdges, ContradictAMotionThatIsWrongAlongTheDirection) {
  for (const double error_m : {0.12, 0.25, -0.25, 0.4}) {  // a scan
    EXPECT_TRUE(drifting(error_m * kAlong).contradict(kAlong)) << error_m;
    EXPECT_TRUE(drifting(error_m * kAlong).contradict(-kAlong)) << error_m;
    EXPECT_FALSE(drifting(error_m * kAlong).contradict(Vector3d::UnitZ())) << error_m;
  }
  EXPECT_TRUE(drifting(0.25 * kAcross).contradict(kAcross));
}

TEST(RecentEdges, DoNotContradictARightMotion) {
  EXPECT_FALSE(drifting(Vector3d::Zero()).contradict(kAlong));
  EXPECT_FALSE(drifting(0.02 * kAlong).contradict(kAlong));
}

// Moved, the other edges agree: 80 of 100 are four times 20.
TEST(RecentEdges, DoNotContradictWhatAQuarterOfThemSupports) {
  EXPECT_TRUE(drifting(0.25 * kAlong, 15).contradict(kAlong));
  EXPECT_FALSE(drifting(0.25 * kAlong, 25).contradict(kAlong));
}

// Elsewhere 15 of 100 edges agree, at the estimate none.
TEST(RecentEdges, DoNotContradictByAFewThatAgreeElsewhere) {
  const Points before = edges_in_a_hall();
  const auto with_agreeing = [&](int count) {
    RecentEdges out;
    for (int scan = 0; scan < 4; ++scan) out.add(before);
    Points last = moved(before, {0, 0, 50});
    for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) last[i] = before[i] + 0.9 * kAlong;
    out.add(last);
    return out;
  };
  EXPECT_FALSE(with_agreeing(15).contradict(kAlong));
  EXPECT_TRUE(with_agreeing(30).contradict(kAlong));
}

TEST(RecentEdges, NeedFiveScansWithFiftyEdgesEach) {
  RecentEdges few;
  for (int scan = 0; scan < 4; ++scan) few.add(moved(edges_in_a_hall(), 0.3 * scan * kAlong));
  EXPECT_FALSE(few.contradict(kAlong));
  few.add(moved(edges_in_a_hall(), 1.2 * kAlong));
  EXPECT_TRUE(few.contradict(kAlong));
  few.clear();
  EXPECT_TRUE(few.empty());
  EXPECT_FALSE(few.contradict(kAlong));
  EXPECT_FALSE(drifting(0.25 * kAlong, 0, 49).contradict(kAlong));
  EXPECT_TRUE(drifting(0.25 * kAlong, 0, 50).contradict(kAlong));
}

// weight = 1 - (0.2 / 0.4)^2, whatever the scans before.
TEST(RecentEdges, AgreementIsThatOfTheLastTwoScans) {
  RecentEdges edges;
  EXPECT_FALSE(edges.agreement());
  edges.add(moved(edges_in_a_hall(), 5 * kAlong));
  EXPECT_FALSE(edges.agreement());
  edges.add(edges_in_a_hall());
  edges.add(moved(edges_in_a_hall(), 0.2 * Vector3d::UnitZ()));
  EXPECT_NEAR(*edges.agreement(), 0.75, 1e-12);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
