#include <memory>
#include <numbers>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "support/toy_scene.hpp"
#include <mapless/odometry/lidar_odometry.hpp>

namespace mapless {
namespace MAPLESS_FILE {

using Scans = std::vector<std::shared_ptr<const LidarScan>>;

// The first ten scans of a sensor at rest in a room, with few points.
Scans ten_scans() {
  const test::ToyScene scene = with_columns(test::toy_room("VLP-16", test::drive(0, 0)), 90);
  Scans scans;
  for (int k = 0; k < 10; ++k) scans.push_back(cast_scan(scene, k).scan);
  return scans;
}

// These scans again and again, as one drive of `count` scans.
Scans repeated_scans(std::size_t count) {
  const Scans ten = ten_scans();
  const Duration period = ten[1]->start - ten[0]->start;
  Scans scans;
  for (std::size_t k = 0; k < count; ++k) {
    LidarScan scan = *ten[k % ten.size()];
    scan.start = ten[0]->start + period * static_cast<double>(k);
    scans.push_back(std::make_shared<const LidarScan>(std::move(scan)));
  }
  return scans;
}

// Two chunks of 256 knots, and what is not final yet.
TEST(LongDrives, KeepsFewKnotsWhereOldMotionIsForgotten) {
  const Scans scans = repeated_scans(800);
  LidarOdometry all, forgetful;
  for (const auto& scan : scans) {
    (void)all.process(scan);
    const OdometryUpdate update = forgetful.process(scan);
    EXPECT_EQ(update.knots.back().T_v0.matrix(), all.knots().back().T_v0.matrix());
    forgetful.forget_before(scan->start);
    ASSERT_LE(forgetful.knots().size(), 2u * 256u + 21u);
    ASSERT_LE(forgetful.trajectory().begin(), scan->start);
  }
  ASSERT_TRUE(forgetful.started());
  EXPECT_EQ(all.knots().size(), scans.size() + 1);
  EXPECT_GT(forgetful.trajectory().begin(), scans[256]->start);
}

// The sensor is covered for a while before it sees a room.
TEST(LongDrives, ASensorThatSeesNothingForLongStartsLater) {
  const Scans seen = ten_scans();
  const Duration period = seen[1]->start - seen[0]->start;
  LidarScan nothing = *seen[0];
  nothing.returns.clear();
  LidarOdometry odometry;
  constexpr int kCovered = 700;
  for (int k = 0; k < kCovered; ++k) {
    nothing.start = seen[0]->start - period * (kCovered - k);
    const OdometryUpdate update = odometry.process(std::make_shared<const LidarScan>(nothing));
    odometry.forget_before(nothing.start);
    EXPECT_EQ(update.outcome, ScanOutcome::few_points);
    ASSERT_LE(update.knots.size(), kMostStartUpScans + 2) << k;
    ASSERT_LE(odometry.knots().size(), 2 * 256 + kMostStartUpScans) << k;
  }
  OdometryUpdate last;
  for (const auto& scan : seen) last = odometry.process(scan);
  EXPECT_TRUE(odometry.started());
  EXPECT_EQ(last.outcome, ScanOutcome::registered);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
