#include <gtest/gtest.h>

#include "support/detection/run_detector.hpp"
#include "support/detection/standing_scene.hpp"
#include <mapless/detection/detector.hpp>

namespace mapless {
namespace MAPLESS_FILE {

constexpr int kGap = 4;    // scans from the query back to the reference scan
constexpr int kQuery = 5;  // has a whole gap before it and one scan after it
constexpr double kTurn_s = 0.1;

/// A wall that moves straight away from a resting sensor at `speed_mps` (towards it: negative), and is
/// `range_m` ahead in scan kQuery; the traces of its points there that lie well within the wall.
std::vector<StageTrace> traces_of_wall(double range_m, double speed_mps) {
  test::ToyBody wall = test::wall_at(range_m - kQuery * kTurn_s * speed_mps);
  wall.velocity_0 = {speed_mps, 0, 0};
  wall.object = 1;
  const test::ToyScene scene = test::with_columns(test::standing({wall}, "HDL-64E-S3"), 450);
  const auto scans = test::scans_of(test::cast_scans(scene, 0, kQuery + 2));
  DetectorParameters parameters = detector_profile("paper");
  parameters.scan_gap = kGap;
  const auto detections = test::detect_all(scans, *scene.trajectory, parameters);
  const CompensatedScan query = compensate(scans[kQuery], *scene.trajectory);
  std::vector<StageTrace> traces;
  for (std::size_t i = 0; i < query.points_0.size(); ++i) {
    if (test::is_ahead(query, i)) traces.push_back(detections[kQuery].trace[i]);
  }
  EXPECT_GT(traces.size(), 1000u);
  return traces;
}

// 8 m/s is 3.2 m in four scans and 0.8 m in one, both beyond the threshold of 0.5 m. The rays of four scans
// ago ended short of the wall; those of the next scan go through its place.
TEST(PublishedPipeline, FindsInTheNextScanThingsThatMoveAway) {
  for (const StageTrace& t : traces_of_wall(15, 8)) {
    ASSERT_EQ(t.candidate, CandidateVerdict::dynamic);
    ASSERT_EQ(t.past, FreespaceVerdict::outside);
    ASSERT_EQ(t.future, FreespaceVerdict::inside);
    ASSERT_TRUE(dynamic_after(t, Stage::filtered));
  }
}

// The rays of four scans ago went through the place of the wall, which proves that it moved. In the next scan
// it is nearer and hides that place, which proves nothing.
TEST(PublishedPipeline, DoesNotCheckForwardThingsThatComeNearer) {
  for (const StageTrace& t : traces_of_wall(15, -8)) {
    ASSERT_EQ(t.past, FreespaceVerdict::inside);
    ASSERT_EQ(t.future, FreespaceVerdict::not_evaluated);
    ASSERT_TRUE(dynamic_after(t, Stage::filtered));
  }
}

// 3 m/s is 1.2 m in four scans, but 0.3 m in one: the next scan ends on the wall as it was, within 0.5 m.
TEST(PublishedPipeline, TakesThingsForStaticThatTheNextScanStillSees) {
  for (const StageTrace& t : traces_of_wall(15, 3)) {
    ASSERT_EQ(t.past, FreespaceVerdict::outside);
    ASSERT_EQ(t.future, FreespaceVerdict::border);
    ASSERT_FALSE(dynamic_after(t, Stage::filtered));
  }
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
