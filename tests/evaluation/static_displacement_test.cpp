#include "evaluation/static_displacement.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include <mapless/core/errors.hpp>

namespace mapless {
namespace MAPLESS_FILE {

constexpr int kColumns = 1000;
constexpr double kTurnsPerSecond = 10;
constexpr double kHubRate = 2 * std::numbers::pi * kTurnsPerSecond;  // [rad/s]
constexpr double kApart = 0.4;                                       // [s]

// A scan of one point `range` metres ahead of the sensor, measured in the middle of the turn.
LidarScan scan_of_one_point(double range, double start_s, SpinDirection direction) {
  auto model = std::make_shared<LidarModel>();
  model->direction = direction;
  model->columns = kColumns;
  model->lasers.resize(1);
  LidarScan scan;
  scan.model = model;
  scan.start = Time::from_seconds(start_s);
  scan.column_period = Duration::from_nanoseconds(100'000);
  scan.columns = kColumns;
  scan.returns.push_back(
      {{static_cast<float>(range), 0, 0}, static_cast<float>(range), 50'000'000, kColumns / 2, 0, 0});
  return scan;
}

// T_0v = (velocity t, Rz(yaw_rate t)).
class Moving final : public Trajectory {
 public:
  Moving(double velocity, double yaw_rate) : velocity_(velocity), yaw_rate_(yaw_rate) {}
  [[nodiscard]] Time begin() const override { return Time::from_seconds(-100); }
  [[nodiscard]] Time end() const override { return Time::from_seconds(100); }
  [[nodiscard]] TrajectoryState at(Time t) const override {
    const double s = t.seconds();
    return {SE3(rotation_z(yaw_rate_ * s), {0, 0, velocity_ * s}).inverse(), Vector6d::Zero()};
  }

 private:
  double velocity_, yaw_rate_;
};

double displacement(double range, const Trajectory& truth, const Trajectory& estimate,
                    SpinDirection direction = SpinDirection::counter_clockwise) {
  const LidarScan query = scan_of_one_point(range, 1 + kApart, direction);
  const LidarScan reference = scan_of_one_point(range, 1, direction);
  const auto out =
      static_displacements(query, poses_of(query, truth, estimate), poses_of(reference, truth, estimate), 1);
  EXPECT_EQ(out.size(), 1u);
  return out.at(0);
}

TEST(StaticDisplacement, IsZeroForTheTruth) {
  const Moving turning(3, 1.5);
  EXPECT_NEAR(displacement(80, turning, turning), 0, 1e-9);
}

TEST(StaticDisplacement, AVelocityErrorGivesItsProductWithTheTimeBetweenTheScans) {
  EXPECT_NEAR(displacement(20, Moving(0, 0), Moving(0.5, 0)), 0.5 * kApart, 1e-9);
  EXPECT_NEAR(displacement(20, Moving(7, 0), Moving(7.5, 0)), 0.5 * kApart, 1e-9);
}

TEST(StaticDisplacement, ATurnRateErrorGrowsWithRange) {
  for (const double range : {5.0, 50.0}) {
    EXPECT_NEAR(displacement(range, Moving(0, 0), Moving(0, 0.1)), 2 * range * std::sin(0.1 * kApart / 2),
                1e-9);
  }
}

// Turning with the hub, the sensor needs more than its period to see a direction again; against it, less:
// the time between the two measurements is the scans' distance over (1 + yaw rate / hub rate).
TEST(StaticDisplacement, UsesTheInstantsAtWhichThePointIsMeasured) {
  const double yaw_rate = 3;
  const double half_column = 0.5 / kTurnsPerSecond / kColumns;
  const Moving truth(0, yaw_rate), estimate(2, yaw_rate);
  EXPECT_NEAR(displacement(30, truth, estimate, SpinDirection::counter_clockwise),
              2 * kApart / (1 + yaw_rate / kHubRate), 2 * half_column);
  EXPECT_NEAR(displacement(30, truth, estimate, SpinDirection::clockwise),
              2 * kApart / (1 - yaw_rate / kHubRate), 2 * half_column);
}

TEST(StaticDisplacement, RefusesAStrideOfZero) {
  const LidarScan scan = scan_of_one_point(10, 1, SpinDirection::clockwise);
  const ScanPoses poses = poses_of(scan, Moving(0, 0), Moving(0, 0));
  EXPECT_THROW((void)static_displacements(scan, poses, poses, 0), ParameterError);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
