#include "odometry/keypoints/keypoints.hpp"

#include <gtest/gtest.h>

namespace mapless {
namespace MAPLESS_FILE {
namespace {

// Two lasers, one after the other in the recording, fire at the same instants into different cubes.
TEST(Keypoints, AreOrderedByTimeAndThenByReturn) {
  constexpr int kInstants = 100;
  std::vector<ScanPoint> points;
  for (int laser = 0; laser < 2; ++laser) {
    for (int i = 0; i < kInstants; ++i) {
      const Eigen::Vector3f p(2.0F * static_cast<float>(i), 4.0F * static_cast<float>(laser), 0);
      points.push_back({p, p.norm(), 1000 * i, laser, static_cast<std::uint32_t>(points.size())});
    }
  }
  OdometryParameters parameters;
  parameters.min_keypoints = 50;
  const std::vector<ScanPoint> found = select_keypoints(points, parameters, 0);
  ASSERT_EQ(found.size(), points.size());
  for (int k = 0; k < 2 * kInstants; ++k) {
    const ScanPoint& point = found[static_cast<std::size_t>(k)];
    EXPECT_EQ(point.time_ns, 1000 * (k / 2));
    EXPECT_EQ(point.return_index, static_cast<std::uint32_t>(k / 2 + kInstants * (k % 2)));
  }
}

}  // namespace
}  // namespace MAPLESS_FILE
}  // namespace mapless
