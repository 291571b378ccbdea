#include "odometry/start_up/joint_registration.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "odometry/map/plane_map.hpp"
#include "odometry/map/points_in_world.hpp"

namespace mapless {
namespace MAPLESS_FILE {

constexpr int kLasers = 40, kColumns = 600, kAxes = 3;
constexpr double kScan_s = 0.1, kSigma_m = 0.02;
constexpr double kStiff = 1e10;          // information of what the prior fixes
constexpr double kPriorSpeed_mps = 0.3;  // along x
const Eigen::Vector3d kHalfRoom_m(9, 7, 5);
// No loss and hardly a change of velocity: the cost is a sum of squares of one unknown, the speed along x.
const RegistrationSettings kSettings = {{1e-6, 1e-6}, {0.5, 1e3}, kSigma_m, 1e-6, 15};

// Scan k of a sensor at rest in the middle of a room.
UsableScan scan_at_rest(int k) {
  std::vector<ScanPoint> points, keypoints;
  for (int column = 0; column < kColumns; ++column) {
    const double azimuth = 2 * std::numbers::pi * column / kColumns;
    const auto since_start = static_cast<std::int32_t>(1e9 * kScan_s * column / kColumns);
    for (int laser = 0; laser < kLasers; ++laser) {
      const double elevation = 0.04 * (laser - kLasers / 2.0 + 0.5);
      const Eigen::Vector3d ray(std::cos(elevation) * std::cos(azimuth),
                                std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
      double range_m = 1e9;
      for (int axis = 0; axis < kAxes; ++axis)
        range_m = std::min(range_m, kHalfRoom_m[axis] / std::max(std::abs(ray[axis]), 1e-9));
      points.push_back({(range_m * ray).cast<float>(), static_cast<float>(range_m), since_start, laser, 0});
      if ((laser + 7 * column) % 10 == 0) keypoints.push_back(points.back());
    }
  }
  const Time start = Time::from_seconds(kScan_s * k);
  TimeBins bins(keypoints, start, Time());
  return {std::move(points), std::move(bins), {}, start, static_cast<std::size_t>(k)};
}

std::vector<TrajectoryKnot> knots_at_speed(double speed_mps) {
  Vector6d varpi = Vector6d::Zero();
  varpi[0] = speed_mps;
  std::vector<TrajectoryKnot> out;
  for (int k = 0; k <= 2; ++k)
    out.push_back({Time::from_seconds(kScan_s * k), SE3::exp(kScan_s * k * varpi), varpi});
  return out;
}

// Information that the keypoints of `scan` have along x in the planes of `other` [1/m^2].
double information_along_x(const UsableScan& scan, const UsableScan& other,
                           const std::vector<TrajectoryKnot>& knots) {
  PlaneMap map(kSigma_m);
  const std::size_t k = other.interval;
  (void)map.insert(points_in_world(other.points, other.start, knots[k], knots[k + 1]));
  std::vector<CachedPlane> planes;
  double out = 0;
  for (const BinSums& bin : sum_residuals(scan.bins, {knots[scan.interval], knots[scan.interval + 1]}, map,
                                          kSettings.weights, planes))
    out += bin.information(0, 0);
  return out;
}

// Two scans at rest that a prior takes for moving at `kPriorSpeed_mps`, with a standard deviation such that
// prior and points have the same information: half that speed must come out. The points see a displacement of
// v x .1 s, once from each scan. Taken twice or by half they would leave a third or two thirds of it.
TEST(JointRegistration, APairOfScansCountsOnceAgainstThePrior) {
  const std::vector<UsableScan> scans = {scan_at_rest(0), scan_at_rest(1)};
  const auto middle = knots_at_speed(kPriorSpeed_mps / 2);
  const double of_points =
      (information_along_x(scans[0], scans[1], middle) + information_along_x(scans[1], scans[0], middle)) / 2;
  Vector12d information = Vector12d::Constant(kStiff);
  information[6] = kInformationRatio * of_points * kScan_s * kScan_s;
  const auto knots = knots_at_speed(kPriorSpeed_mps);
  const auto found =
      register_jointly(knots, prior_of(knots.front(), information.asDiagonal()), scans, kSettings);
  ASSERT_TRUE(found);
  for (const TrajectoryKnot& knot : found->knots)
    EXPECT_NEAR(knot.varpi[0], kPriorSpeed_mps / 2, 0.1 * kPriorSpeed_mps);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
