#include "odometry/start_up/backward_registration.hpp"

#include <vector>

#include <gtest/gtest.h>

#include "odometry/start_up/room_scan.hpp"

namespace mapless {
namespace MAPLESS_FILE {

constexpr double kScan_s = 0.2;
const RegistrationSettings kSettings = {{0.03, 0.5}, {0.5, 2.5}, 0.02, 1e-4, 15};

// A sensor that turns about z, faster and faster, in the middle of a room.
double angle_at(double t) { return 1.5 * t + 0.75 * t * t; }
Vector6d varpi_at(double t) {
  Vector6d out = Vector6d::Zero();
  out[5] = 1.5 + 1.5 * t;
  return out;
}
SE3 pose_at(double t) { return SE3::exp(angle_at(t) * Vector6d::Unit(5)); }

TrajectoryKnot knot_at(int k) {
  return {Time::from_seconds(kScan_s * k), pose_at(kScan_s * k), varpi_at(kScan_s * k)};
}

// The scan after knot k.
UsableScan scan_of(int k) { return test::room_scan(k, kScan_s, pose_at); }

double turn_error_rad(const TrajectoryKnot& a, const TrajectoryKnot& b, int from, int to) {
  const SE3 moved = b.T_v0 * a.T_v0.inverse(),
            truth = pose_at(kScan_s * to) * pose_at(kScan_s * from).inverse();
  return (moved * truth.inverse()).log().tail<3>().norm();
}

// The first two poses are displaced by .12 rad and .1 m. The third scan is missing: its interval has no scan.
TEST(BackwardRegistration, CorrectsTheFirstScansAndKeepsTheLastTwo) {
  std::vector<TrajectoryKnot> knots;
  for (int k = 0; k <= 6; ++k) knots.push_back(knot_at(k));
  const SE3 wrong = SE3::exp(0.12 * Vector6d::Unit(5) + 0.1 * Vector6d::Unit(0));
  for (std::size_t k = 0; k < 2; ++k) {
    knots[k].T_v0 = wrong * knots[k].T_v0;
    knots[k].varpi *= k == 0 ? -1 : 0.5;
  }
  const std::vector<UsableScan> scans = {scan_of(0), scan_of(1), scan_of(3), scan_of(4), scan_of(5)};
  const auto found = follow_backwards(knots, scans, kSettings);
  ASSERT_TRUE(found);
  ASSERT_EQ(found->size(), knots.size());
  EXPECT_LT((found->front().T_v0 * knots.front().T_v0.inverse()).log().norm(), 1e-12) << "the first pose";
  for (int k = 0; k < 6; ++k) {
    const auto i = static_cast<std::size_t>(k);
    EXPECT_EQ((*found)[i].time, knots[i].time);
    EXPECT_LT(turn_error_rad((*found)[i], (*found)[i + 1], k, k + 1), k < 4 ? 0.002 : 1e-6) << k;
    EXPECT_NEAR((*found)[i].varpi[5], varpi_at(kScan_s * k)[5], k < 5 ? 0.1 : 1e-12) << k;
  }
}

TEST(BackwardRegistration, NoSolutionGivesNone) {
  std::vector<TrajectoryKnot> knots;
  for (int k = 0; k <= 3; ++k) knots.push_back(knot_at(k));
  const std::vector<UsableScan> scans = {scan_of(0), scan_of(1), scan_of(2)};
  RegistrationSettings settings = kSettings;
  settings.density = {1e-30, 1e-30};  // a prior that no computer can solve for
  EXPECT_FALSE(follow_backwards(knots, scans, settings));
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
