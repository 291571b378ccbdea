#include "odometry/start_up/joint_registration.hpp"

#include <vector>

#include <gtest/gtest.h>

#include "odometry/map/plane_map.hpp"
#include "odometry/map/points_in_world.hpp"
#include "odometry/start_up/room_scan.hpp"

namespace mapless {
namespace MAPLESS_FILE {

constexpr double kScan_s = 0.1, kSigma_m = 0.02;
constexpr double kStiff = 1e10;          // information of what the prior fixes
constexpr double kPriorSpeed_mps = 0.3;  // along x
// No loss and hardly a change of velocity: the cost is a sum of squares of one unknown, the speed along x.
const RegistrationSettings kSettings = {{1e-6, 1e-6}, {0.5, 1e3}, kSigma_m, 1e-6, 15};

// Scan k of a sensor at rest in the middle of a room.
UsableScan scan_at_rest(int k) {
  return test::room_scan(k, kScan_s, [](double) { return SE3(); });
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
