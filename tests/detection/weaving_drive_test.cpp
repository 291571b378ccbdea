#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "support/detection/run_detector.hpp"
#include "support/toy_scene.hpp"
#include <mapless/io/labels.hpp>
#include <mapless/odometry/lidar_odometry.hpp>

namespace mapless {
namespace MAPLESS_FILE {

using Eigen::Vector3d;

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kGround_m = -1.8;
constexpr double kSpeed_mps = 8;
constexpr int kScans = 60;

// 64 lasers, 1800 columns.
LidarModel evenly_spaced() {
  LidarModel model;
  model.name = "64 x 1800";
  model.columns = 1800;
  model.min_range_m = 1;
  model.max_range_m = 100;
  model.lasers.resize(64);
  for (int l = 0; l < 64; ++l)
    model.lasers[static_cast<std::size_t>(l)].elevation_rad = (-24.8 + 26.8 * l / 63) * kDegree;
  return model;
}

// Half a radian a second to the left and to the right, four seconds for both.
std::shared_ptr<const Trajectory> weave() {
  constexpr double kStep_s = 0.01;
  std::vector<TimedPose> poses;
  SE3 T_v0;
  for (int i = 0; i <= 100 * (kScans / 10 + 1); ++i) {
    poses.push_back({Time::from_seconds(kStep_s * i), T_v0});
    Vector6d varpi = Vector6d::Zero();
    varpi[0] = -kSpeed_mps;
    varpi[5] = -0.5 * std::sin(2 * std::numbers::pi * kStep_s * (i + 0.5) / 4);
    T_v0 = SE3::exp(kStep_s * varpi) * T_v0;
  }
  return std::make_shared<SampledTrajectory>(std::move(poses), Duration::from_seconds(kStep_s), "weave");
}

test::ToyBody standing_on_ground(double x, double y, const Vector3d& size, double yaw_rad) {
  return test::toy_box({x, y, kGround_m + size.z() / 2 + 0.02}, size / 2, yaw_rad);
}

// Boxes left and right of a road along x, others that drive on it or cross it, and two that walk.
test::ToyScene boxes_on_a_plain(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto between = [&](double a, double b) {
    return a + (b - a) * static_cast<double>(random() >> 11) * 0x1p-53;
  };
  test::ToyScene scene;
  scene.model = std::make_shared<const LidarModel>(evenly_spaced());
  scene.trajectory = weave();
  scene.range_noise_m = 0.02;
  scene.seed = seed;
  scene.world.push_back(test::toy_ground(kGround_m));
  for (const double side : {-1.0, 1.0}) {
    for (double x = -30; x < 110; x += between(6, 12)) {
      if (std::abs(x - 30) < 8 || std::abs(x - 65) < 8) continue;  // crossings
      const Vector3d size(between(1, 6), between(1, 4), between(1, 5));
      scene.world.push_back(standing_on_ground(x, side * between(14, 30), size, between(-1.5, 1.5)));
    }
  }
  std::uint16_t object = 0;
  const auto moving = [&](double x, double y, const Vector3d& size, const Vector3d& velocity_0) {
    test::ToyBody body = standing_on_ground(x, y, size, std::atan2(velocity_0.y(), velocity_0.x()));
    body.velocity_0 = velocity_0;
    body.object = ++object;
    scene.world.push_back(body);
  };
  const Vector3d car(4.2, 1.8, 1.5), person(0.5, 0.5, 1.75);
  moving(between(35, 45), 7, car, {-between(6, 10), 0, 0});
  moving(between(85, 105), 7, car, {-between(6, 10), 0, 0});
  moving(between(14, 20), between(-4, -3), car, {between(7, 11), 0, 0});
  moving(between(-15, -10), between(-6, -5), car, {between(9, 11), 0, 0});
  moving(30, between(-40, -30), car, {0, between(5, 9), 0});
  moving(65, between(40, 60), car, {0, -between(5, 9), 0});
  moving(between(15, 25), 11, person, {between(1, 1.6), 0, 0});
  moving(between(40, 50), -10, person, {-between(1, 1.6), 0, 0});
  return scene;
}

double iou(const std::vector<Detection>& detections, const std::vector<test::ToyScan>& scans) {
  double both = 0, either = 0;
  for (std::size_t k = 0; k < detections.size(); ++k) {
    for (std::size_t i = 0; i < detections[k].object.size(); ++i) {
      const std::uint32_t label = scans[k].labels[detections[k].scan->returns[i].input_index];
      const bool moves = motion_of_label(label) == MotionTruth::moving;
      both += moves && detections[k].dynamic(i) ? 1 : 0;
      either += moves || detections[k].dynamic(i) ? 1 : 0;
    }
  }
  return both / either;
}

class WeavingDrive : public testing::TestWithParam<std::uint64_t> {};

// Flat ground and boxes: difficult is the sensor's own motion alone. Nineteen points in twenty, from the
// first scan on.
TEST_P(WeavingDrive, IsRightWithTruePosesAndWithItsOwn) {
  SCOPED_TRACE(GetParam());
  const test::ToyScene scene = boxes_on_a_plain(GetParam());
  const auto toy = test::cast_scans(scene, 0, kScans);
  const auto scans = test::scans_of(toy);
  LidarOdometry odometry;
  for (const auto& scan : scans) odometry.process(scan);
  const double with_true_poses = iou(test::detect_all(scans, *scene.trajectory, {}), toy);
  const double with_its_own = iou(test::detect_all(scans, odometry.trajectory(), {}), toy);
  EXPECT_GE(with_true_poses, 0.95);
  EXPECT_GE(with_its_own, with_true_poses - 0.01);
}

INSTANTIATE_TEST_SUITE_P(Seeds, WeavingDrive, testing::Values(1, 2));

}  // namespace MAPLESS_FILE
}  // namespace mapless
