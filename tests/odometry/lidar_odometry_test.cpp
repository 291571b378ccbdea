#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "support/toy_scene.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/evaluation/trajectory_evaluation.hpp>
#include <mapless/odometry/lidar_odometry.hpp>

namespace mapless {
namespace MAPLESS_FILE {

using Eigen::Vector3d;
using test::ToyScene;

constexpr double kDegree = std::numbers::pi / 180;
using Scans = std::vector<std::shared_ptr<const LidarScan>>;

Scans cast(const ToyScene& scene, int first, int count) {
  Scans scans;
  for (int k = first; k < first + count; ++k) scans.push_back(cast_scan(scene, k).scan);
  return scans;
}

struct Drive {
  LidarOdometry odometry;
  std::vector<OdometryUpdate> updates;  ///< with the state that a later scan decided

  void process(const Scans& scans) {
    for (const auto& scan : scans) {
      updates.push_back(odometry.process(scan));
      const auto decided = std::min(updates.back().decided_scans, updates.size());
      for (auto one = updates.end() - static_cast<std::ptrdiff_t>(decided); one != updates.end(); ++one)
        one->state = updates.back().state;
    }
  }
};

double root_mean_square(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += v * v;
  return std::sqrt(sum / static_cast<double>(values.size()));
}

/// Errors of a drive against the truth.
struct Errors {
  std::vector<double> position_m, relative_m, relative_deg, speed;
};

Errors errors_of(const Drive& drive, const ToyScene& scene, const Scans& scans, std::size_t from = 1) {
  Errors out;
  const Trajectory& truth = *scene.trajectory;
  const SE3 T_first = truth.at(scans[0]->start).T_v0;
  for (std::size_t k = from; k < scans.size(); ++k) {
    // The final estimate: the knots of the first scans change until the odometry has started.
    const Time end = drive.updates[k].knots.back().time;
    const TrajectoryState knot = drive.odometry.trajectory().at(end);
    const TrajectoryState expected = truth.at(end);
    const SE3 T_0v = knot.T_v0.inverse();
    const SE3 T_0v_true = (expected.T_v0 * T_first.inverse()).inverse();
    out.position_m.push_back((T_0v.translation() - T_0v_true.translation()).norm());
    const SE3 step = knot.T_v0 * drive.odometry.trajectory().at(scans[k]->start).T_v0.inverse();
    const SE3 true_step = expected.T_v0 * truth.at(scans[k]->start).T_v0.inverse();
    const Vector6d relative = (step * true_step.inverse()).log();
    out.relative_m.push_back(relative.head<3>().norm());
    out.relative_deg.push_back(relative.tail<3>().norm() / kDegree);
    out.speed.push_back((knot.varpi - expected.varpi).head<3>().norm());
  }
  return out;
}

/// How far the trajectory alone moves a static point between scans 4 apart [m], 95th percentile.
double displacement_m(const Drive& drive, const ToyScene& scene, const Scans& scans) {
  std::vector<double> displacements;
  const Trajectory& estimate = drive.odometry.trajectory();
  for (std::size_t k = 4; k < scans.size(); ++k) {
    for (std::size_t i = 0; i < scans[k]->returns.size(); i += 97) {
      const LidarReturn& r = scans[k]->returns[i];
      const Time now = scans[k]->time_of(r);
      const Time before = scans[k - 4]->start + (now - scans[k]->start);
      const Vector3d p_now = r.position_v.cast<double>();
      const Vector3d p_before =
          scene.trajectory->at(before).T_v0 * (scene.trajectory->at(now).T_v0.inverse() * p_now);
      const Vector3d a = estimate.at(now).T_v0.inverse() * p_now;
      displacements.push_back((a - estimate.at(before).T_v0.inverse() * p_before).norm());
    }
  }
  return quantile(displacements, 0.95).value();
}

ToyScene room(double speed, double degrees_per_second) {
  return test::toy_room("VLP-16", test::drive(speed, degrees_per_second * kDegree));
}

TEST(LidarOdometry, FollowsAStreetFromSpeed) {
  const ToyScene street = test::toy_street("VLP-16");  // 8 m/s from the first scan on, then a turn
  const Scans scans = cast(street, 0, 45);
  Drive drive;
  drive.process(scans);
  for (std::size_t k = 1; k < scans.size(); ++k) {
    EXPECT_EQ(drive.updates[k].outcome, ScanOutcome::registered) << k;
    EXPECT_EQ(drive.updates[k].state, MotionState::good) << k;
    EXPECT_EQ(drive.updates[k].knots.back().time, scans[k]->end());
  }
  const Errors errors = errors_of(drive, street, scans);
  for (const double error : errors.position_m) EXPECT_LT(error, 0.10);
  EXPECT_LT(root_mean_square(errors.relative_m), 0.02);
  EXPECT_LT(root_mean_square(errors.relative_deg), 0.2);
  EXPECT_LT(root_mean_square(errors.speed), 0.25);
  EXPECT_LT(displacement_m(drive, street, scans), 0.04);
}

TEST(LidarOdometry, FollowsADenseScanner) {
  const ToyScene street = test::toy_street();
  const Scans scans = cast(street, 0, 12);
  Drive drive;
  drive.process(scans);
  const Errors errors = errors_of(drive, street, scans);
  for (const double error : errors.position_m) EXPECT_LT(error, 0.05);
  EXPECT_LT(root_mean_square(errors.relative_deg), 0.05);
  EXPECT_LT(displacement_m(drive, street, scans), 0.03);
}

TEST(LidarOdometry, StandsStill) {
  const ToyScene scene = room(0, 0);
  const Scans scans = cast(scene, 0, 8);
  Drive drive;
  drive.process(scans);
  const Errors errors = errors_of(drive, scene, scans);
  // Sixteen rays per column hardly hit floor and ceiling, and at rest always along the same lines: the height
  // during the first scan is the most uncertain.
  for (const double error : errors.position_m) EXPECT_LT(error, 0.03);
  EXPECT_LT(root_mean_square(errors.speed), 0.1);
}

TEST(LidarOdometry, FollowsAFastTurnOfTheHand) {
  for (const double turn_rate : {-200.0, 90.0, 200.0}) {
    SCOPED_TRACE(turn_rate);
    const ToyScene scene = room(0.7, turn_rate);
    const Scans scans = cast(scene, 0, 12);
    Drive drive;
    drive.process(scans);
    const Errors errors = errors_of(drive, scene, scans);
    for (const double error : errors.position_m) EXPECT_LT(error, 0.10);
    EXPECT_LT(root_mean_square(errors.relative_deg), 0.25);
    EXPECT_LT(displacement_m(drive, scene, scans), 0.04);
  }
}

TEST(LidarOdometry, ADroppedScanIsBridged) {
  const ToyScene street = test::toy_street("VLP-16");
  Scans scans = cast(street, 0, 20);
  scans.erase(scans.begin() + 9, scans.begin() + 11);
  Drive drive;
  drive.process(scans);
  for (const double error : errors_of(drive, street, scans).position_m) EXPECT_LT(error, 0.10);
  // The gap also ends with a knot.
  const auto& knots = drive.updates[9].knots;
  ASSERT_GE(knots.size(), 2u);
  EXPECT_EQ(knots[knots.size() - 2].time, scans[9]->start);
  EXPECT_EQ(knots.back().time, scans[9]->end());
}

std::shared_ptr<const LidarScan> without_returns(const LidarScan& scan) {
  LidarScan empty = scan;
  empty.returns.clear();
  std::fill(empty.cells.begin(), empty.cells.end(), empty_cell(ReturnCode::faulty));
  return std::make_shared<const LidarScan>(empty);
}

TEST(LidarOdometry, AnEmptyScanIsExtrapolatedWithThePriorAndReported) {
  const ToyScene street = test::toy_street("VLP-16");
  Scans scans = cast(street, 0, 16);
  scans[8] = without_returns(*scans[8]);
  Drive drive;
  drive.process(scans);
  EXPECT_EQ(drive.updates[8].outcome, ScanOutcome::few_points);
  EXPECT_EQ(drive.updates[8].state, MotionState::lost);
  EXPECT_EQ(drive.updates[9].outcome, ScanOutcome::registered);
  EXPECT_GT(drive.updates[8].covariance(0, 0), drive.updates[7].covariance(0, 0));
  for (const double error : errors_of(drive, street, scans).position_m) EXPECT_LT(error, 0.15);
  EXPECT_LT(errors_of(drive, street, scans).position_m.back(), 0.10);
}

TEST(LidarOdometry, BeginsWithTheFirstScanThatHasPoints) {
  const ToyScene street = test::toy_street("VLP-16");
  Scans scans = cast(street, 0, 8);
  scans[0] = without_returns(*scans[0]);
  Drive drive;
  drive.process(scans);
  EXPECT_EQ(drive.updates[0].outcome, ScanOutcome::few_points);
  EXPECT_EQ(drive.updates[1].outcome, ScanOutcome::first);
  for (const double error : errors_of(drive, street, scans, 2).position_m) EXPECT_LT(error, 0.15);
}

TEST(LidarOdometry, AScanDeliveredTwiceIsReported) {
  const ToyScene street = test::toy_street("VLP-16");
  Scans scans = cast(street, 0, 14);
  LidarScan repeated = *scans[6];
  repeated.start = scans[7]->start;
  scans[7] = std::make_shared<const LidarScan>(repeated);
  Drive drive;
  drive.process(scans);
  EXPECT_EQ(drive.updates[7].outcome, ScanOutcome::repeated);
  for (const double error : errors_of(drive, street, scans).position_m) EXPECT_LT(error, 0.15);
}

TEST(LidarOdometry, RefusesInvalidScansAndContinues) {
  const ToyScene street = test::toy_street("VLP-16");
  const Scans scans = cast(street, 0, 4);
  LidarOdometry odometry;
  (void)odometry.process(scans[0]);
  (void)odometry.process(scans[1]);
  const auto knots = odometry.knots().size();
  EXPECT_THROW((void)odometry.process(scans[1]), InputError);
  EXPECT_THROW((void)odometry.process(scans[0]), InputError);
  EXPECT_THROW((void)odometry.process(nullptr), InputError);
  LidarScan compensated = *scans[2];
  compensated.compensated_to = compensated.start;
  EXPECT_THROW((void)odometry.process(std::make_shared<const LidarScan>(compensated)), InputError);
  EXPECT_EQ(odometry.knots().size(), knots);
  EXPECT_EQ(odometry.process(scans[2]).outcome, ScanOutcome::registered);
}

// Random returns: none may enter the map, and the state must stay finite.
TEST(LidarOdometry, RandomReturnsAreReported) {
  const ToyScene street = test::toy_street("VLP-16");
  Scans scans = cast(street, 0, 14);
  for (const std::size_t k : {6u, 7u}) {
    LidarScan noise = *scans[k];
    std::uint32_t x = 12345;
    for (LidarReturn& r : noise.returns) {
      for (int axis = 0; axis < 3; ++axis) {
        x = 1664525 * x + 1013904223;
        r.position_v[axis] = (k == 6 ? 1e30F : 60.F) * (static_cast<float>(x >> 8) * 0x1p-23F - 1);
      }
    }
    scans[k] = std::make_shared<const LidarScan>(noise);
  }
  Drive drive;
  drive.process(scans);
  EXPECT_EQ(drive.updates[6].outcome, ScanOutcome::few_points);
  EXPECT_EQ(drive.updates[7].outcome, ScanOutcome::unmatched);
  for (const auto& knot : drive.odometry.knots()) {
    EXPECT_TRUE(knot.T_v0.matrix().allFinite());
    EXPECT_TRUE(knot.varpi.allFinite());
  }
  for (const double error : errors_of(drive, street, scans).position_m) EXPECT_LT(error, 0.2);
}

// The same sensor with other rotation rates.
TEST(LidarOdometry, FollowsSensorsOfAnyRateAndAnyNumberOfLasers) {
  for (const auto& [sensor, rate_hz] : {std::pair("VLP-16", 5.), {"VLP-16", 20.}, {"OS1-128", 10.}}) {
    SCOPED_TRACE(sensor + std::to_string(rate_hz));
    ToyScene scene = test::toy_room(sensor, test::drive(1.5, 20 * kDegree));
    LidarModel model = *scene.model;
    model.rotation_rate_hz = rate_hz;
    scene.model = std::make_shared<const LidarModel>(model);
    const Scans scans = cast(scene, 0, 8);
    ASSERT_NEAR((scans[1]->start - scans[0]->start).seconds(), 1 / rate_hz, 1e-3);
    Drive drive;
    drive.process(scans);
    const Errors errors = errors_of(drive, scene, scans);
    for (const double error : errors.position_m) EXPECT_LT(error, 0.10);
    EXPECT_LT(root_mean_square(errors.relative_deg), 0.25);
  }
}

TEST(LidarOdometry, ATrajectorySnapshotStaysAsItIs) {
  const ToyScene scene = room(2, 10 * kDegree);
  const Scans scans = cast(scene, 0, 9);
  LidarOdometry odometry;
  EXPECT_GT(odometry.trajectory_snapshot()->begin(), odometry.trajectory_snapshot()->end());
  for (std::size_t k = 0; k < 7; ++k) (void)odometry.process(scans[k]);
  ASSERT_TRUE(odometry.started());
  const std::vector<TrajectoryKnot> knots = odometry.knots();
  const auto snapshot = odometry.trajectory_snapshot();
  for (std::size_t k = 7; k < scans.size(); ++k) (void)odometry.process(scans[k]);
  ASSERT_NE(odometry.knots()[knots.size() - 1].varpi, knots.back().varpi) << "later scans correct a knot";
  EXPECT_EQ(snapshot->end(), knots.back().time);
  for (const TrajectoryKnot& knot : knots) {
    const TrajectoryState expected = GaussianProcessTrajectory(knots, "test").at(knot.time);
    EXPECT_EQ(snapshot->at(knot.time).T_v0.matrix(), expected.T_v0.matrix());
    EXPECT_EQ(snapshot->at(knot.time).varpi, expected.varpi);
  }
}

// With all returns removed as dynamic, the map has nothing left for the next scan to register to.
TEST(LidarOdometry, RemovesDynamicPointsFromTheMap) {
  const ToyScene scene = room(0, 0);
  const Scans scans = cast(scene, 0, 7);
  LidarOdometry emptied, undisturbed;
  for (std::size_t k = 0; k < scans.size(); ++k) {
    (void)undisturbed.process(scans[k]);
    const bool started = emptied.started();
    const OdometryUpdate update = emptied.process(scans[k]);
    EXPECT_EQ(update.outcome == ScanOutcome::unmatched, started) << k;
    EXPECT_TRUE(!started || update.inlier_ratio < 0.01) << k;
    if (!emptied.started()) continue;
    for (std::size_t i = 0; i <= k; ++i)
      emptied.remove_dynamic_points(*scans[i], std::vector<std::uint16_t>(scans[i]->returns.size(), 1));
  }
  ASSERT_TRUE(emptied.started());
  const auto before = undisturbed.knots().back();
  undisturbed.remove_dynamic_points(*scans[3], std::vector<std::uint16_t>(scans[3]->returns.size(), 0));
  undisturbed.remove_dynamic_points(*scans[3], {1, 1, 1});
  EXPECT_EQ(undisturbed.knots().back().T_v0.matrix(), before.T_v0.matrix());
}

// A tunnel with a constant cross-section: its points do not constrain the motion along it.
TEST(LidarOdometry, AFeaturelessTunnelIsReportedAndExtrapolatedWithThePrior) {
  ToyScene tunnel = room(10, 0);
  for (auto& body : tunnel.world) body = test::toy_box({0, 0, 0}, {1, 1, 1});
  tunnel.world.clear();
  for (const double side : {-1.0, 1.0}) {
    tunnel.world.push_back(test::toy_box({0, side * 4, 0}, {2000, 0.5, 4}));
    tunnel.world.push_back(test::toy_box({0, 0, side * 3}, {2000, 5, 0.5}));
  }
  // Pillars at the beginning determine the speed; then nothing does.
  tunnel.world.push_back(test::toy_box({7, 3, 0}, {0.5, 0.5, 3}));
  tunnel.world.push_back(test::toy_box({4, -3, 0}, {0.5, 0.5, 3}));
  tunnel.world.push_back(test::toy_box({-6, 3, 0}, {0.5, 0.5, 3}));
  const Scans scans = cast(tunnel, 0, 45);
  OdometryParameters parameters;
  // The pillars, half a metre wide, constrain the speed from up to 60 m: with this radius the map has lost
  // them before scan 35, 35 m on.
  parameters.map_radius_m = 20;
  Drive drive = {LidarOdometry(parameters), {}};
  drive.process(scans);
  const Vector3d p_30 = drive.updates[30].knots.back().T_v0.inverse().translation();
  int reported = 0;
  for (std::size_t k = 35; k < scans.size(); ++k) {
    SCOPED_TRACE(k);
    const Degeneracy& degeneracy = drive.updates[k].degeneracy;
    // The noise of the normals, whose ratio is up to 4e-4 here, lets a scan of ten or so pass its threshold.
    EXPECT_LT(degeneracy.constraint_ratio[0], 1e-3);
    reported += degeneracy.unconstrained;
    EXPECT_GT(std::abs(degeneracy.directions_v.col(0).x()), 0.99);
    const auto& knot = drive.updates[k].knots.back();
    EXPECT_NEAR(-knot.varpi[0], 10, 1.5) << "the speed of the prior";
    const Vector3d p_0 = knot.T_v0.inverse().translation();
    EXPECT_LT((p_0 - p_30).tail<2>().norm(), 0.05) << "the walls constrain the other directions";
  }
  EXPECT_GE(reported, 8) << "of ten scans";
}

TEST(LidarOdometry, TheSameForAnyNumberOfThreads) {
  const Scans scans = cast(with_columns(test::toy_street("VLP-16"), 600), 0, 6);
  std::vector<LidarOdometry> runs(2);
  for (std::size_t run = 0; run < 2; ++run) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, run == 0 ? 1 : 4);
    for (const auto& scan : scans) (void)runs[run].process(scan);
    ASSERT_TRUE(runs[run].started());
  }
  for (std::size_t k = 0; k < runs[0].knots().size(); ++k) {
    EXPECT_EQ(runs[0].knots()[k].T_v0.matrix(), runs[1].knots()[k].T_v0.matrix());
    EXPECT_EQ(runs[0].knots()[k].varpi, runs[1].knots()[k].varpi);
  }
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
