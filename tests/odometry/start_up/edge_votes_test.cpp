#include "odometry/start_up/edge_votes.hpp"

#include <algorithm>
#include <random>

#include <gtest/gtest.h>

namespace mapless {
namespace MAPLESS_FILE {

constexpr double kScan_s = 0.1;

// The edges of scan number k: `count` static points within 40 m, each seen once a scan at an instant of its
// own, by a sensor with the constant velocity `varpi`: p_v(t) = exp(t varpi) p_0. The first `moving` of them
// move with the sensor.
UsableScan scan_of(int k, const Vector6d& varpi, int count, int moving, double scan_s = kScan_s) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> metres(-40, 40), part(0, 1);
  UsableScan out = {{}, TimeBins(), {}, Time::from_seconds(k * scan_s), 0};
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d p_0(metres(random), metres(random), metres(random) / 10);
    const double within_s = scan_s * i / count;
    const double t = i < moving ? 0 : scan_s * k + within_s;
    const Eigen::Vector3d p_v = SE3::exp(t * varpi) * p_0;
    out.edges.push_back(
        {p_v.cast<float>(), static_cast<float>(p_v.norm()), static_cast<std::int32_t>(1e9 * within_s), 0, 0});
  }
  return out;
}

// At 30 m/s and 30 deg/s, a third of the edges moving with the sensor.
TEST(EdgeMotions, TheBestIsThatOfTheStaticEdges) {
  Vector6d varpi;
  varpi << -28, 10, 1, 0.02, -0.03, 0.5;
  const auto found = edge_motions(scan_of(0, varpi, 300, 100), scan_of(1, varpi, 300, 100));
  ASSERT_FALSE(found.empty());
  EXPECT_LT((found[0].varpi - varpi).head<3>().norm(), 0.2);
  EXPECT_LT((found[0].varpi - varpi).tail<3>().norm(), 0.02);
  EXPECT_GT(found[0].agreement, 0.5);
}

TEST(EdgeMotions, ATurnOfTheHandIsFound) {
  Vector6d varpi;
  varpi << 0.3, -0.2, 0.1, -2.2, 0.3, 0.4;
  const auto found = edge_motions(scan_of(0, varpi, 300, 0), scan_of(1, varpi, 300, 0));
  ASSERT_FALSE(found.empty());
  EXPECT_LT((found[0].varpi - varpi).tail<3>().norm(), 0.02);
}

// The same at 5 Hz, where the sensor moves by 8 m between two scans.
TEST(EdgeMotions, ScansOfFiveTurnsASecondAreSearchedAsFar) {
  for (const double speed_mps : {22., 30., 40.}) {
    const Vector6d varpi = -speed_mps * Vector6d::Unit(0);
    const auto found = edge_motions(scan_of(0, varpi, 1000, 400, 0.2), scan_of(1, varpi, 1000, 400, 0.2));
    ASSERT_FALSE(found.empty()) << speed_mps;
    EXPECT_TRUE(std::any_of(found.begin(), found.end(), [&](const EdgeMotion& one) {
      return (one.varpi - varpi).norm() < 0.2;
    })) << speed_mps;
  }
}

TEST(EdgeMotions, FewEdgesOrOnesThatAgreeWithNoMotionGiveNone) {
  const Vector6d rest = Vector6d::Zero();
  EXPECT_TRUE(edge_motions(scan_of(0, rest, 40, 0), scan_of(1, rest, 40, 0)).empty());
  UsableScan other = scan_of(1, rest, 300, 0);
  std::mt19937 random(9);
  std::uniform_real_distribution<float> metres(-40, 40);
  for (ScanPoint& edge : other.edges) edge.position_v = {metres(random), metres(random), metres(random) / 10};
  EXPECT_TRUE(edge_motions(scan_of(0, rest, 300, 0), other).empty());
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
