#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "support/detection/run_detector.hpp"
#include "support/detection/standing_scene.hpp"
#include <mapless/detection/detector.hpp>

namespace mapless {
namespace MAPLESS_FILE {

constexpr int kGap = 4;    // scans from the query back to the reference scan
constexpr int kQuery = 5;  // has a whole gap before it and one scan after it
constexpr double kTurn_s = 0.1;

/// A wall that moves straight away from a resting sensor at `speed_mps` (towards it: negative), and is 15 m
/// ahead in scan kQuery. The traces of its points there: those well within the wall, and not straight ahead,
/// where the seam of the scan makes the time between two scans 0 or 0.2 s instead of 0.1 s.
std::vector<StageTrace> traces_of_wall(double speed_mps) {
  test::ToyBody wall = test::wall_at(15 - kQuery * kTurn_s * speed_mps);
  wall.velocity_0 = {speed_mps, 0, 0};
  wall.object = 1;
  const test::ToyScene scene = test::with_columns(test::standing({wall}, "HDL-64E-S3"), 900);
  const auto scans = test::scans_of(test::cast_scans(scene, 0, kQuery + 2));
  DetectorParameters parameters = detector_profile("paper");
  parameters.scan_gap = kGap;
  const auto detections = test::detect_all(scans, *scene.trajectory, parameters);
  const CompensatedScan query = compensate(scans[kQuery], *scene.trajectory);
  std::vector<StageTrace> traces;
  for (std::size_t i = 0; i < query.points_0.size(); ++i) {
    const bool off_seam = std::abs(query.points_0[i].y()) > 0.1 * query.points_0[i].x();
    if (test::is_ahead(query, i) && off_seam) traces.push_back(detections[kQuery].trace[i]);
  }
  EXPECT_GT(traces.size(), 1000u);
  return traces;
}

/// Share of the traces with these verdicts.
double share(const std::vector<StageTrace>& traces, FreespaceVerdict past, FreespaceVerdict future,
             bool dynamic) {
  const auto matching = std::count_if(traces.begin(), traces.end(), [&](const StageTrace& t) {
    return t.candidate == CandidateVerdict::dynamic && t.past == past && t.future == future &&
           dynamic_after(t, Stage::filtered) == dynamic;
  });
  return static_cast<double>(matching) / static_cast<double>(traces.size());
}

constexpr double kMost = 0.98;  // points at the edge of the image have no normal, or no rays around them

// 8 m/s is 3.2 m in four scans and 0.8 m in one, both beyond the threshold of 0.5 m. The rays of four scans
// ago ended short of the wall; those of the next scan go through its place.
TEST(PublishedPipeline, FindsInTheNextScanThingsThatMoveAway) {
  EXPECT_GE(share(traces_of_wall(8), FreespaceVerdict::outside, FreespaceVerdict::inside, true), kMost);
}

// The rays of four scans ago went through the place of the wall, which proves that it moved. In the next scan
// it is nearer and hides that place, which proves nothing.
TEST(PublishedPipeline, DoesNotCheckForwardThingsThatComeNearer) {
  EXPECT_GE(share(traces_of_wall(-8), FreespaceVerdict::inside, FreespaceVerdict::not_evaluated, true),
            kMost);
}

// 3 m/s is 1.2 m in four scans, but 0.3 m in one: the next scan ends on the wall as it was, within 0.5 m.
TEST(PublishedPipeline, TakesThingsForStaticThatTheNextScanStillSees) {
  EXPECT_GE(share(traces_of_wall(3), FreespaceVerdict::outside, FreespaceVerdict::border, false), kMost);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
