#include "odometry/registration/mapped_trajectory.hpp"

#include <gtest/gtest.h>

namespace mapless {
namespace MAPLESS_FILE {

TrajectoryKnot moved_by(double metres, double radians) {
  Vector6d step = Vector6d::Zero();
  step[0] = metres;
  step[5] = radians;
  return {Time(), SE3::exp(step), Vector6d::Zero()};
}

// In two scans a sensor at 45 m/s moves by 9 m at 10 Hz and by 18 m at 5 Hz; a start predicts rest.
TEST(MappedTrajectory, ALongerScanMayBeCorrectedByMore) {
  const TrajectoryKnot rest = moved_by(0, 0);
  EXPECT_TRUE(is_plausible(moved_by(9, 0), rest, 0.1));
  EXPECT_TRUE(is_plausible(moved_by(9, 0), rest, 0.05));
  EXPECT_FALSE(is_plausible(moved_by(18, 0), rest, 0.1));
  EXPECT_TRUE(is_plausible(moved_by(18, 0), rest, 0.2));
  EXPECT_FALSE(is_plausible(moved_by(0, 2), rest, 0.1));
  EXPECT_TRUE(is_plausible(moved_by(0, 2), rest, 0.2));
  EXPECT_FALSE(is_plausible(moved_by(21, 0), rest, 0.2));
  EXPECT_FALSE(is_plausible(moved_by(0, 2.5), rest, 5));
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
