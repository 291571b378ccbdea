#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "odometry/registration/mapped_trajectory.hpp"
#include "support/toy_scene.hpp"
#include <mapless/odometry/lidar_odometry.hpp>

// Scenes in which the points constrain the motion poorly: the odometry must report it and not diverge.
namespace mapless {
namespace MAPLESS_FILE {

using Eigen::Vector3d;
using test::ToyScene;
using Scans = std::vector<std::shared_ptr<const LidarScan>>;

Scans cast(const ToyScene& scene, int count) {
  Scans scans;
  for (int k = 0; k < count; ++k) scans.push_back(cast_scan(scene, k).scan);
  return scans;
}

double position_error_m(const LidarOdometry& odometry, const ToyScene& scene, Time t) {
  const SE3 T_true = scene.trajectory->at(t).T_v0 * scene.trajectory->at(Time()).T_v0.inverse();
  return (odometry.trajectory().at(t).T_v0.inverse().translation() - T_true.inverse().translation()).norm();
}

// Straight ahead at 3 m/s; then, within a scan, a turn at 75 deg/s begins, which the motion prior finds
// unlikely.
class SuddenTurn final : public Trajectory {
 public:
  [[nodiscard]] Time begin() const override { return before_->begin(); }
  [[nodiscard]] Time end() const override { return before_->end(); }
  [[nodiscard]] TrajectoryState at(Time t) const override {
    if (t < kTurn) return before_->at(t);
    TrajectoryState out = after_->at(Time() + (t - kTurn));
    out.T_v0 = out.T_v0 * before_->at(kTurn).T_v0;
    return out;
  }

 private:
  static constexpr Time kTurn = Time::from_nanoseconds(860'000'000);
  std::shared_ptr<const Trajectory> before_ = test::drive(3, 0);
  std::shared_ptr<const Trajectory> after_ = test::drive(3, 1.3);
};

TEST(HardPlaces, ASuddenTurnIsFollowed) {
  ToyScene street = test::toy_street("VLP-16");
  street.trajectory = std::make_shared<SuddenTurn>();
  LidarOdometry odometry;
  for (const auto& scan : cast(street, 15)) {
    const OdometryUpdate update = odometry.process(scan);
    if (!odometry.started()) continue;
    EXPECT_LT(position_error_m(odometry, street, update.knots.back().time), 0.1);
  }
}

// Boxes at the beginning determine the speed; then the ground is the only surface.
TEST(HardPlaces, AnOpenFieldIsReportedAndExtrapolatedWithThePrior) {
  ToyScene field = test::toy_room("VLP-16", test::drive(10, 0));
  field.world = {test::toy_ground(-1.8)};
  for (const double x : {-6., 4., 9., 14.})
    for (const double y : {-5., 6.}) field.world.push_back(test::toy_box({x, y, 0}, {1, 0.7, 1.8}, 0.3 * x));
  const Scans scans = cast(field, 45);
  OdometryParameters parameters;
  parameters.map_radius_m = 20;  // so that the boxes are soon out of the map
  LidarOdometry odometry(parameters);
  for (std::size_t k = 0; k < scans.size(); ++k) {
    const OdometryUpdate update = odometry.process(scans[k]);
    if (k < 38) continue;
    SCOPED_TRACE(k);
    EXPECT_EQ(update.outcome, ScanOutcome::registered);
    EXPECT_EQ(update.degeneracy.unconstrained, 2) << "along the ground";
    EXPECT_LT(std::abs(update.degeneracy.directions_v.leftCols<2>().row(2).norm()), 0.1);
    const auto& knot = update.knots.back();
    EXPECT_NEAR(knot.varpi.head<3>().norm(), 10, 1.5) << "the speed of the prior";
    EXPECT_NEAR(knot.T_v0.inverse().translation().z(), 0, 0.05) << "the ground constrains the height";
  }
}

// Straight ahead at 6 m/s; at rest from scan `scans` on.
class Halt final : public Trajectory {
 public:
  explicit Halt(int scans) : halt_(Time::from_nanoseconds(scans * std::int64_t{100'000'000})) {}
  [[nodiscard]] Time begin() const override { return drive_->begin(); }
  [[nodiscard]] Time end() const override { return drive_->end(); }
  [[nodiscard]] TrajectoryState at(Time t) const override {
    TrajectoryState out = drive_->at(std::min(t, halt_));
    if (t > halt_) out.varpi.setZero();
    return out;
  }

 private:
  Time halt_;
  std::shared_ptr<const Trajectory> drive_ = test::drive(6, 0);
};

// The ground is the only surface; poles show little but edges.
ToyScene poles(double radius_m, std::shared_ptr<const Trajectory> trajectory) {
  ToyScene field = test::toy_room("VLP-16", std::move(trajectory));
  field.world = {test::toy_ground(-1.8)};
  for (int i = -8; i <= 20; ++i)
    field.world.push_back(test::toy_cylinder({1.3 * i, 9 * std::sin(i * i), 0}, radius_m, 4));
  return field;
}

// The states of 12 scans among thin poles: after a halt the registration goes on as the prior expects.
std::vector<MotionState> states_among_poles(std::shared_ptr<const Trajectory> trajectory) {
  const ToyScene field = poles(0.05, std::move(trajectory));
  LidarOdometry odometry;
  std::vector<MotionState> out;
  for (int k = 0; k < 12; ++k) {
    const OdometryUpdate update = odometry.process(cast_scan(field, k).scan);
    out.push_back(update.state);
    std::fill(out.end() - static_cast<std::ptrdiff_t>(update.decided_scans), out.end(), update.state);
  }
  return out;
}

TEST(HardPlaces, AMotionThatEdgesContradictIsLost) {
  const auto moving = states_among_poles(test::drive(6, 0));
  EXPECT_EQ(std::count(moving.begin(), moving.end(), MotionState::lost), 0);
  // From scan 10 on the estimate is .6 m a scan ahead.
  const auto stopped = states_among_poles(std::make_shared<Halt>(10));
  EXPECT_EQ(std::count(stopped.begin(), stopped.begin() + 10, MotionState::lost), 0);
  EXPECT_EQ(stopped.back(), MotionState::lost);
}

// The start has the motion of its first two scans.
TEST(HardPlaces, AStartThatEdgesContradictIsLost) {
  const auto stopped = states_among_poles(std::make_shared<Halt>(2));
  EXPECT_EQ(std::count(stopped.begin(), stopped.begin() + 10, MotionState::lost), 10);
}

// Pillars in two rows, 2 m apart on average. From scan to scan the sensor passes half of that.
ToyScene pillars(double irregularity_m) {
  ToyScene road = test::toy_room("VLP-16", test::drive(10, 0));
  road.range_noise_m = 0.02;
  road.world = {test::toy_ground(-1.8)};
  for (int i = -30; i <= 30; ++i) {
    const double x = 2.0 * i + irregularity_m * std::sin(i * i);
    for (const double y : {-20., 20.}) road.world.push_back(test::toy_cylinder({x, y, 0}, 0.3, 4));
  }
  return road;
}

// The state of the scans of the start.
MotionState state_of_start(const ToyScene& scene) {
  LidarOdometry odometry;
  for (int k = 0; k < 12; ++k) {
    const OdometryUpdate update = odometry.process(cast_scan(scene, k).scan);
    if (odometry.started()) return update.state;
  }
  ADD_FAILURE() << "no start";
  return MotionState::lost;
}

// Forwards, each pillar is half a spacing behind where it was. Backwards, half a spacing ahead, where its
// neighbour would be: if all are alike, both motions explain every scan.
TEST(HardPlaces, AStartWithTwoEqualMotionsIsDegenerate) {
  EXPECT_EQ(state_of_start(pillars(0)), MotionState::degenerate);
  EXPECT_EQ(state_of_start(pillars(0.7)), MotionState::good);
}

// The planes leave open whether the motion is right, and the edges say that it is.
TEST(HardPlaces, AStartThatEdgesSupportIsGood) {
  ToyScene field = poles(0.1, test::drive(6, 0));
  field.range_noise_m = 0.02;
  EXPECT_EQ(state_of_start(field), MotionState::good);
}

TEST(HardPlaces, AScanOfFewReturnsIsExtrapolatedWithThePrior) {
  const ToyScene street = test::toy_street("VLP-16");
  Scans scans = cast(street, 11);
  LidarScan few = *scans[8];
  few.returns.resize(40);
  for (auto& cell : few.cells) cell = cell >= 40 ? empty_cell(ReturnCode::faulty) : cell;
  scans[8] = std::make_shared<const LidarScan>(few);
  LidarOdometry odometry;
  for (std::size_t k = 0; k < scans.size(); ++k) {
    const OdometryUpdate update = odometry.process(scans[k]);
    EXPECT_EQ(update.outcome == ScanOutcome::few_points, k == 8) << k;
    if (!odometry.started()) continue;
    EXPECT_LT(position_error_m(odometry, street, update.knots.back().time), 0.15) << k;
  }
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
