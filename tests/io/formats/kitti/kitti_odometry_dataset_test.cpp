#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/bare_cloud.hpp"
#include "support/temporary_folder.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/geometry/compensated_scan.hpp>
#include <mapless/io/dataset.hpp>
#include <mapless/io/labels.hpp>

namespace mapless {
namespace MAPLESS_FILE {

using test::Cloud;
using test::TemporaryFolder;
using test::write_text;
using ::testing::HasSubstr;

namespace fs = std::filesystem;

constexpr double kPi = std::numbers::pi;

// Camera 0 from velodyne: x right = -y, y down = -z, z forward = x, a little displaced.
const char* const kCalibration = "P0: 1 0 0 0 0 1 0 0 0 0 1 0\nTr: 0 -1 0 0.1 0 0 -1 -0.2 1 0 0 -0.3\n";

// A sensor that drives and turns left at a steady rate; its state at mid-scan k, world from sensor at scan 0.
Vector6d body_velocity() {
  Vector6d v;
  v << 10, 0, 0, 0, 0, 0.5;
  return v;
}

SE3 T_0v_at(double t_s) { return SE3::exp(body_velocity() * t_s); }

std::string row(const SE3& pose) {
  const Eigen::Matrix4d m = pose.matrix();
  std::string text;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 4; ++j) text += fmt::format("{:.12g} ", m(i, j));
  }
  text.back() = '\n';
  return text;
}

// The cloud as KITTI publishes it: each point moved to where it would be from the pose at mid-scan.
Cloud compensated(const Cloud& measured, double turn_s) {
  Cloud cloud = measured;
  for (Eigen::Vector3f& p : cloud) {
    const double t = turn_s * (-std::atan2(p.y(), p.x()) / kPi) / 2;
    p = (T_0v_at(t) * p.cast<double>()).cast<float>();
  }
  return cloud;
}

class KittiOdometry : public ::testing::Test {
 protected:
  void SetUp() override {
    LidarModel model = test::make_bare_cloud_model(16, 500);
    for (Laser& laser : model.lasers) {
      laser.azimuth_offset_rad = 0;
      laser.origin_h_m.head<2>().setZero();
    }
    measured_ = test::make_bare_cloud(model, 0);
    truth_ = model;
    for (int k = 0; k < 3; ++k) {
      test::write_kitti_cloud(sequence() / "velodyne" / fmt::format("{:06}.bin", k),
                              compensated(measured_, 0.1));
    }
    write_text(sequence() / "times.txt", "0.000000e+00\n1.000000e-01\n2.000000e-01\n");
    write_text(sequence() / "calib.txt", kCalibration);
    write_text(sequence() / "poses.txt", poses(3));
  }

  // KITTI's poses: camera 0 at k in the frame of camera 0 at 0.
  [[nodiscard]] static std::string poses(int count) {
    Eigen::Matrix3d R;
    R << 0, -1, 0, 0, 0, -1, 1, 0, 0;
    const SE3 Tr(R, {0.1, -0.2, -0.3});
    std::string text;
    for (int k = 0; k < count; ++k) text += row(Tr * T_0v_at(0.1 * k) * Tr.inverse());
    return text;
  }

  [[nodiscard]] fs::path sequence() const { return folder_ / "sequences" / "07"; }

  TemporaryFolder folder_;
  Cloud measured_;
  LidarModel truth_;
};

TEST_F(KittiOdometry, ScansAreCentredOnTheirTimesAndMarkedAsCompensated) {
  const auto dataset = open_dataset(sequence());
  EXPECT_EQ(dataset->format(), "kitti");
  ASSERT_EQ(dataset->size(), 3U);
  EXPECT_EQ(dataset->scan_start(1).nanoseconds(), 50'000'000);
  EXPECT_EQ(dataset->scan_end(1).nanoseconds(), 150'000'000);
  const LidarScan scan = dataset->read(1);
  EXPECT_EQ(scan.compensated_to.value().nanoseconds(), 100'000'000);
  EXPECT_EQ(scan.returns.size(), measured_.size());
}

TEST_F(KittiOdometry, TheTrajectoryIsThatOfTheSensor) {
  const auto dataset = open_dataset(sequence());
  ASSERT_NE(dataset->trajectory(), nullptr);
  for (const double t : {-0.04, 0.0, 0.13, 0.2, 0.24}) {
    SCOPED_TRACE(t);
    const SE3 error = dataset->trajectory()->at(Time::from_seconds(t)).T_v0 * T_0v_at(t);
    EXPECT_LT(error.log().norm(), 1e-6);
  }
}

TEST_F(KittiOdometry, FindsPosesBesideTheSequences) {
  fs::create_directories(folder_ / "poses");
  fs::rename(sequence() / "poses.txt", folder_ / "poses" / "07.txt");
  EXPECT_NE(open_dataset(sequence())->trajectory(), nullptr);
  EXPECT_NE(open_dataset(sequence() / "")->trajectory(), nullptr);
  fs::remove(folder_ / "poses" / "07.txt");
  EXPECT_EQ(open_dataset(sequence())->trajectory(), nullptr);
}

// The sensor nods by 0.004 rad within each turn, 0.06 m at the walls: the poses, one a turn, do not show it.
TEST_F(KittiOdometry, AMotionThatThePosesDoNotFollowIsDoubted) {
  const auto beams = [&] {
    const auto dataset = open_dataset(sequence());
    const auto results = check_recording(*dataset, dataset->trajectory(), 0, dataset->size());
    return *std::find_if(results.begin(), results.end(), [](const auto& r) { return r.name == "beams"; });
  };
  EXPECT_EQ(beams().trust, Trust::right) << beams().measured;
  Cloud nodding = compensated(measured_, 0.1);
  for (Eigen::Vector3f& p : nodding) {
    const double phase = std::atan2(p.y(), p.x());  // once a turn, 0 in its middle
    p = (so3_exp({0, 0.004 * std::sin(phase), 0}) * p.cast<double>()).cast<float>();
  }
  for (int k = 0; k < 3; ++k)
    test::write_kitti_cloud(sequence() / "velodyne" / fmt::format("{:06}.bin", k), nodding);
  EXPECT_EQ(beams().trust, Trust::doubtful) << beams().measured;
}

TEST_F(KittiOdometry, CompensationIsUndoneForTheEstimateAndByTheCaller) {
  const auto dataset = open_dataset(sequence());
  const LidarModel& model = *dataset->model();
  ASSERT_EQ(model.lasers.size(), 16U);
  for (std::size_t i = 0; i < 16; ++i) {
    EXPECT_NEAR(model.lasers[i].elevation_rad, truth_.lasers[i].elevation_rad, 0.02 * kPi / 180);
    EXPECT_NEAR(model.lasers[i].origin_h_m.z(), truth_.lasers[i].origin_h_m.z(), 0.01);
  }
  const LidarScan restored = restore_measured_rays(dataset->read(1), *dataset->trajectory());
  for (const LidarReturn& r : restored.returns) {
    // Near the seam a compensated point may have been measured at either end of the turn.
    const Eigen::Vector3f& p = measured_[r.input_index];
    if (std::abs(std::atan2(p.y(), p.x())) > 176 * kPi / 180) continue;
    ASSERT_LT((r.position_v - p).norm(), 0.01F);
  }
}

TEST_F(KittiOdometry, RefusesFewerPosesThanScans) {
  write_text(sequence() / "poses.txt", poses(2));
  try {
    (void)open_dataset(sequence());
    FAIL() << "accepted";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("poses.txt"));
  }
}

TEST_F(KittiOdometry, RefusesMissingTimes) {
  write_text(sequence() / "times.txt", "0\n0.1\n");
  try {
    (void)open_dataset(sequence());
    FAIL() << "accepted";
  } catch (const InputError& error) {
    EXPECT_EQ(error.detail().where, (sequence() / "times.txt").string());
    EXPECT_EQ(error.detail().value, "2");
  }
  write_text(sequence() / "times.txt", "0\nx\n0.2\n");
  EXPECT_THROW((void)open_dataset(sequence()), InputError);
  fs::remove(sequence() / "times.txt");
  EXPECT_THROW((void)open_dataset(sequence()), InputError);
}

TEST_F(KittiOdometry, TimesThatDecreaseAreReportedAsSuch) {
  write_text(sequence() / "times.txt", "0\n0.2\n0.1\n");
  try {
    (void)open_dataset(sequence());
    FAIL() << "accepted";
  } catch (const InputError& error) {
    EXPECT_EQ(error.detail().where, (sequence() / "times.txt").string() + ":3");
  }
}

TEST_F(KittiOdometry, RefusesPosesWithoutCalibration) {
  fs::remove(sequence() / "calib.txt");
  try {
    (void)open_dataset(sequence());
    FAIL() << "accepted";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("calib.txt"));
  }
}

TEST_F(KittiOdometry, ReadsLabelsOfSemanticKitti) {
  std::vector<std::uint32_t> labels(measured_.size(), 252U | (3U << 16));
  fs::create_directories(sequence() / "labels");
  write_label_file(sequence() / "labels" / "000001.label", labels);
  const auto dataset = open_dataset(sequence());
  EXPECT_EQ(dataset->read_labels(1).value(), labels);
  EXPECT_FALSE(dataset->read_labels(0).has_value());
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
