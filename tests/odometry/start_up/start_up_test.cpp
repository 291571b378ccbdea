#include <memory>
#include <numbers>
#include <string>

#include <gtest/gtest.h>

#include <mapless/lidar/lidar_model.hpp>
#include <mapless/lidar/lidar_scan.hpp>
#include <mapless/odometry/lidar_odometry.hpp>
#include <mapless/simulation/scene.hpp>
#include <mapless/simulation/simulated_sensor.hpp>

// Starts that went wrong, of simulated drives with sixteen lasers, which know the truth.
namespace mapless {
namespace MAPLESS_FILE {

constexpr double kRight_m = 0.2;  // over four scans; those that went wrong were off by 0.35 m and more
constexpr int kAfterwards = 12;   // scans, by when any start is decided

/// A sensor on its way through a scene, whose recording begins with scan `first`.
class SimulatedStart {
 public:
  SimulatedStart(const std::string& scene, std::uint64_t seed, int first)
      : scene_(make_scene(scene, {seed, 0.1 * (first + kAfterwards + 1), true})),
        truth_(std::make_shared<const SampledTrajectory>(scene_.poses, Duration(), "scene")),
        world_(scene_.world),
        sensor_(std::make_shared<const LidarModel>(named_model("VLP-16")), truth_, world_,
                {0.02, true, seed}) {
    for (int k = 0; k < kAfterwards; ++k) process(first + k);
  }

  /// How far, after the motion from instant `a` to instant `b`, the sensor is from where it says [m].
  [[nodiscard]] double error_m(Time a, Time b) const {
    const auto moved = [&](const Trajectory& t) { return t.at(a).T_v0 * t.at(b).T_v0.inverse(); };
    return (moved(odometry.trajectory()).translation() - moved(*truth_).translation()).norm();
  }

  /// The same of the turn.
  [[nodiscard]] double turn_error_deg(Time a, Time b) const {
    const auto moved = [&](const Trajectory& t) { return t.at(a).T_v0 * t.at(b).T_v0.inverse(); };
    const SE3 error = moved(odometry.trajectory()) * moved(*truth_).inverse();
    return error.log().tail<3>().norm() * 180 / std::numbers::pi;
  }

  LidarOdometry odometry;
  std::vector<Time> starts;
  int started_with = 0;  ///< scans

 private:
  void process(int number) {
    const auto scan = sensor_.lidar_scan(number);
    starts.push_back(scan->start);
    (void)odometry.process(scan);
    if (odometry.started() && started_with == 0) started_with = static_cast<int>(starts.size());
  }

  Scene scene_;
  std::shared_ptr<const Trajectory> truth_;
  SimulatedWorld world_;
  SimulatedSensor sensor_;
};

void expect_right(const SimulatedStart& start) {
  ASSERT_TRUE(start.odometry.started());
  for (std::size_t k = 0; k + 4 < start.starts.size(); ++k)
    EXPECT_LT(start.error_m(start.starts[k], start.starts[k + 4]), kRight_m) << "from scan " << k;
}

// In the hand, in a tunnel: with five scans four motions up to 2.5 m/s apart had agreed with as many points
// to one in 250, and that the sensor stood seemed as good as any.
TEST(StartUp, WaitsWhereTheFirstScansLeaveTheSpeedOpen) {
  const SimulatedStart tunnel("tunnel", 701, 0);
  EXPECT_GT(tunnel.started_with, 5);
  EXPECT_LE(tunnel.started_with, 10);
  expect_right(tunnel);
}

// On a motorway, among many who overtake and are overtaken: rising at 22 m/s, past everything that was seen,
// nothing speaks against the motion, and hardly anything for it.
TEST(StartUp, AMotionThatLeavesMostOfTheScanWithoutAPlaceIsNone) {
  expect_right(SimulatedStart("highway", 201, 5));
}

// Registered all together, these scans left the right speed after 16 steps, for the half of it and less.
TEST(StartUp, RegisteredTogetherScansDoNotLeaveTheMotionThatAgrees) {
  expect_right(SimulatedStart("highway", 300, 300));
}

// On top of a hill, no two of the first scans go together. They had been left where the sensor began.
TEST(StartUp, ScansThatFoundNoPlaceAreRegisteredAfterwards) { expect_right(SimulatedStart("flyer", 601, 0)); }

// On top of a hill, hardly a point of any scan has a plane in the one before: none had been registered for
// more than a second.
TEST(StartUp, ScansOfWhichNoTwoHoldOneAnotherAreRegisteredFromRest) {
  const SimulatedStart flyer("flyer", 801, 0);
  EXPECT_EQ(flyer.started_with, 8);
  expect_right(flyer);
  for (std::size_t k = 0; k + 4 < flyer.starts.size(); ++k)
    EXPECT_LT(flyer.turn_error_deg(flyer.starts[k], flyer.starts[k + 4]), 2) << "from scan " << k;
}

// The first two went with one another, but wrongly, by few points.
TEST(StartUp, AMotionThatFewPointsOfTwoScansAgreeWithIsNotTheLast) {
  expect_right(SimulatedStart("flyer", 602, 68));
}

// Where the speed is told, nobody waits longer.
TEST(StartUp, FiveScansAreEnoughInATown) {
  const SimulatedStart town("town1", 601, 0);
  EXPECT_EQ(town.started_with, 5);
  expect_right(town);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
