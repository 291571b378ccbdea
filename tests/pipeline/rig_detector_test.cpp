#include <iterator>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/detection/run_detector.hpp"
#include "support/toy_scene.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/pipeline/online_detector.hpp>

namespace mapless {
namespace MAPLESS_FILE {

using Eigen::Vector3d;
using Scans = std::vector<std::shared_ptr<const LidarScan>>;

constexpr int kScans = 16;  // odometry starts with the fifth to the tenth

const SE3& T_roof_bumper() {
  static const SE3 T(so3_exp({0.02, 0.1, 0.3}), {1.5, 0.2, -0.9});
  return T;
}

const test::ToyScene& street() {
  static const test::ToyScene scene = with_columns(test::toy_street("VLP-16"), 400);
  return scene;
}

test::ToyScene street_from_bumper() {
  test::ToyScene scene = street();
  scene.trajectory =
      std::make_shared<const MountedTrajectory>(street().trajectory, T_roof_bumper().inverse());
  return scene;
}

const Scans& roof() {
  static const Scans all = test::scans_of(test::cast_scans(street(), 0, kScans));
  return all;
}
const Scans& bumper() {
  static const Scans all = test::scans_of(test::cast_scans(street_from_bumper(), 0, kScans));
  return all;
}

// The vehicle's frame is neither sensor's.
std::vector<RigSensor> two_sensors() {
  const SE3 T_b_roof(so3_exp({0, 0.05, -1}), {0.3, 0, 1.9});
  return {{"roof", T_b_roof, {}, {}}, {"bumper", T_b_roof * T_roof_bumper(), {}, {}}};
}

void append(std::vector<RigScan>& all, std::vector<RigScan> more) {
  std::move(more.begin(), more.end(), std::back_inserter(all));
}

std::vector<LabelledScan> of_sensor(const std::vector<RigScan>& all, std::size_t sensor) {
  std::vector<LabelledScan> out;
  for (const RigScan& scan : all) {
    if (scan.sensor == sensor) out.push_back(scan.labelled);
  }
  return out;
}

std::vector<RigScan> run(RigDetector& rig, const std::shared_ptr<const Trajectory>& given) {
  std::vector<RigScan> all;
  for (std::size_t k = 0; k < roof().size(); ++k) {
    append(all, rig.push(0, roof()[k], given));
    if (rig.sensors().size() > 1) append(all, rig.push(1, bumper()[k], given));
  }
  append(all, rig.flush());
  return all;
}

void expect_near(const SE3& a, const SE3& b, double tolerance) {
  EXPECT_LT((a.inverse() * b).log().norm(), tolerance);
}

// T_wv and a screw: the pose is the product, the velocity its derivative.
TEST(MountedTrajectory, HasTheDerivativeOfItsPoseAsVelocity) {
  const auto of_v = street().trajectory;
  const MountedTrajectory mounted(of_v, T_roof_bumper().inverse());
  const Time t = Time::from_seconds(1.3);
  const Duration step = Duration::from_seconds(1e-4);
  const TrajectoryState state = mounted.at(t);
  expect_near(state.T_v0, T_roof_bumper().inverse() * of_v->at(t).T_v0, 1e-12);
  const Vector6d numeric =
      (mounted.at(t + step).T_v0 * mounted.at(t - step).T_v0.inverse()).log() / (2 * step.seconds());
  EXPECT_LT((state.varpi - numeric).norm(), 1e-5);
  EXPECT_GT(state.varpi.norm(), 1);
}

TEST(MountedTrajectory, ExtrapolatesAtConstantVelocityAndNoFarther) {
  const auto poses = std::make_shared<const SampledTrajectory>(
      std::vector<TimedPose>{{Time::from_seconds(0), SE3()},
                             {Time::from_seconds(1), SE3(Eigen::Matrix3d::Identity(), {-2, 0, 0})}},
      Duration(), "test");
  const MountedTrajectory mounted(poses, SE3(), Duration::from_seconds(0.5));
  expect_near(mounted.at(Time::from_seconds(1.25)).T_v0, SE3(Eigen::Matrix3d::Identity(), {-2.5, 0, 0}),
              1e-9);
  expect_near(mounted.at(Time::from_seconds(-0.5)).T_v0, SE3(Eigen::Matrix3d::Identity(), {1, 0, 0}), 1e-9);
  EXPECT_THROW(static_cast<void>(mounted.at(Time::from_seconds(1.6))), TrajectoryDomainError);
}

void expect_same_as_alone(const std::shared_ptr<const Trajectory>& given) {
  OnlineDetector online;
  std::vector<LabelledScan> alone;
  const auto add = [&](std::vector<LabelledScan> more) {
    std::move(more.begin(), more.end(), std::back_inserter(alone));
  };
  for (const auto& scan : roof()) add(online.push(scan, given));
  add(online.flush());
  RigDetector rig({{"roof", T_roof_bumper(), {}, {}}});
  const std::vector<LabelledScan> found = of_sensor(run(rig, given), 0);
  ASSERT_EQ(found.size(), alone.size());
  for (std::size_t k = 0; k < alone.size(); ++k) {
    EXPECT_EQ(found[k].detection.sequence_number, k);
    EXPECT_EQ(found[k].detection.object, alone[k].detection.object);
    EXPECT_EQ(found[k].detection.trace, alone[k].detection.trace);
    EXPECT_EQ(found[k].detection.probability, alone[k].detection.probability);
    EXPECT_EQ(found[k].T_0v().matrix(), alone[k].T_0v().matrix());
  }
}

TEST(RigDetector, OfOneSensorLabelsAsAnOnlineDetector) {
  expect_same_as_alone(street().trajectory);
  expect_same_as_alone(nullptr);
}

TEST(RigDetector, LabelsEveryScanOfEverySensorInOrder) {
  for (const auto& given : {street().trajectory, std::shared_ptr<const Trajectory>()}) {
    RigDetector rig(two_sensors());
    const std::vector<RigScan> all = run(rig, given);
    for (std::size_t sensor = 0; sensor < 2; ++sensor) {
      const std::vector<LabelledScan> found = of_sensor(all, sensor);
      const Scans& pushed = sensor == 0 ? roof() : bumper();
      ASSERT_EQ(found.size(), pushed.size());
      for (std::size_t k = 0; k < found.size(); ++k) {
        EXPECT_EQ(found[k].scan().start, pushed[k]->start);
        EXPECT_EQ(found[k].detection.sequence_number, k);
        EXPECT_TRUE(found[k].detection.motion_known);
        EXPECT_EQ(found[k].scan().returns.size(), pushed[k]->returns.size());
      }
    }
  }
}

// Along given poses of the roof, and along its own odometry: the bumper is where the vehicle puts it.
TEST(RigDetector, TheMotionOfTheOtherSensorFollowsFromItsPlace) {
  for (const auto& given : {street().trajectory, std::shared_ptr<const Trajectory>()}) {
    RigDetector rig(two_sensors());
    const std::vector<RigScan> all = run(rig, given);
    const std::vector<LabelledScan> of_roof = of_sensor(all, 0), of_bumper = of_sensor(all, 1);
    for (std::size_t k = 0; k < of_bumper.size(); ++k) {
      const SE3 T_between = of_roof[k].T_0v().inverse() * of_bumper[k].T_0v();
      // Estimates of the same instant differ by what a later scan corrects.
      expect_near(T_between, T_roof_bumper(), given ? 1e-9 : 0.02);
    }
  }
}

// What the other sensor saw through changes labels, of either sensor; each scan alone is not enough for that.
TEST(RigDetector, SensorsShareWhatTheySawThrough) {
  RigDetector rig(two_sensors());
  const std::vector<RigScan> all = run(rig, street().trajectory);
  const auto votes_changed = [&](std::size_t sensor, const Scans& scans, const Trajectory& trajectory) {
    const std::vector<Detection> alone = test::detect_all(scans, trajectory, {});
    const std::vector<LabelledScan> found = of_sensor(all, sensor);
    std::size_t more = 0, less = 0;
    for (std::size_t k = 0; k < alone.size(); ++k) {
      for (std::size_t i = 0; i < alone[k].trace.size(); ++i) {
        const bool before = alone[k].trace[i].candidate == CandidateVerdict::dynamic;
        const bool now = found[k].detection.trace[i].candidate == CandidateVerdict::dynamic;
        more += now && !before ? 1 : 0;
        less += before && !now ? 1 : 0;
      }
    }
    EXPECT_EQ(less, 0u);
    return more;
  };
  EXPECT_GT(votes_changed(0, roof(), *street().trajectory), 0u);
  EXPECT_GT(votes_changed(1, bumper(), *street_from_bumper().trajectory), 0u);
}

// Stamps of the bumper 3.7 s behind: with the offset in the rig the labels are the same.
TEST(RigDetector, EachSensorHasItsOwnClock) {
  const Duration behind = Duration::from_seconds(3.7);
  std::vector<RigSensor> sensors = two_sensors();
  RigDetector rig(sensors);
  const std::vector<RigScan> expected = run(rig, street().trajectory);
  sensors[1].clock_offset = behind;
  RigDetector other(sensors);
  std::vector<RigScan> found;
  for (std::size_t k = 0; k < roof().size(); ++k) {
    append(found, other.push(0, roof()[k], street().trajectory));
    auto late = std::make_shared<LidarScan>(*bumper()[k]);
    late->start = late->start - behind;
    append(found, other.push(1, late, street().trajectory));
  }
  append(found, other.flush());
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t k = 0; k < found.size(); ++k) {
    EXPECT_EQ(found[k].sensor, expected[k].sensor);
    EXPECT_EQ(found[k].labelled.detection.object, expected[k].labelled.detection.object);
    EXPECT_EQ(found[k].labelled.scan().start, expected[k].labelled.scan().start);
  }
}

// The roof falls silent: scans of the bumper come out without labels once kMostWaiting wait, in their order.
TEST(RigDetector, ScansWithoutMotionGetNoLabels) {
  RigDetector rig(two_sensors());
  std::vector<RigScan> all;
  for (std::size_t k = 0; k <= RigDetector::kMostWaiting; ++k) {
    EXPECT_TRUE(all.empty());
    auto scan = std::make_shared<LidarScan>(*bumper().front());
    scan->start = Time::from_seconds(0.1 * static_cast<double>(k));
    append(all, rig.push(1, scan));
  }
  EXPECT_EQ(all.size(), 1u);
  append(all, rig.flush());
  ASSERT_EQ(all.size(), RigDetector::kMostWaiting + 1);
  for (std::size_t k = 0; k < all.size(); ++k) {
    EXPECT_FALSE(all[k].labelled.detection.motion_known);
    EXPECT_EQ(all[k].labelled.detection.sequence_number, k);
    EXPECT_EQ(all[k].labelled.trajectory, nullptr);
    EXPECT_THAT(all[k].labelled.detection.object, testing::Each(0));
  }
}

TEST(RigDetector, RefusesWhatItCannotUse) {
  EXPECT_THROW(RigDetector(std::vector<RigSensor>()), ParameterError);
  EXPECT_THROW(RigDetector({{"a", {}, {}, {}}, {"a", {}, {}, {}}}), ParameterError);
  EXPECT_THROW(RigDetector({{"a", {}, Duration::from_seconds(1), {}}}), ParameterError);
  RigDetector rig(two_sensors());
  EXPECT_THROW(static_cast<void>(rig.push(2, roof()[0])), ParameterError);
  EXPECT_THROW(static_cast<void>(rig.push(0, nullptr)), ParameterError);
  static_cast<void>(rig.push(0, roof()[0], street().trajectory));
  EXPECT_THROW(static_cast<void>(rig.push(1, bumper()[0])), InputError);
  EXPECT_THROW(static_cast<void>(rig.push(0, roof()[0], street().trajectory)), InputError);
  EXPECT_NO_THROW(static_cast<void>(rig.push(1, bumper()[0], street().trajectory)));
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
