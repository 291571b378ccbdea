#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/paths.hpp"
#include "support/temporary_folder.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/trajectory_file.hpp>

namespace mapless {
namespace MAPLESS_FILE {

using test::TemporaryFolder;
using testing::AllOf;
using testing::HasSubstr;

constexpr const char* kIdentityRow = "1 0 0 0 0 1 0 0 0 0 1 0\n";

double pose_difference(const SE3& a, const SE3& b) { return (a * b.inverse()).log().norm(); }

Vector6d random_vector(std::mt19937& random, double translation, double rotation) {
  std::uniform_real_distribution<double> uniform(-1, 1);
  Vector6d v;
  for (int i = 0; i < 6; ++i) v[i] = uniform(random) * (i < 3 ? translation : rotation);
  return v;
}

class TrajectoryFile : public testing::Test {
 protected:
  std::filesystem::path write(const std::string& name, const std::string& text) {
    test::write_text(folder_ / name, text);
    return folder_ / name;
  }
  SampledTrajectory read(const std::string& text) {
    return read_trajectory_file(write("poses.txt", text), options_);
  }
  std::string refusal(const std::string& text) {
    try {
      (void)read(text);
    } catch (const InputError& error) {
      EXPECT_FALSE(error.detail().remedy.empty());
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
      EXPECT_THAT(error.what(), HasSubstr((folder_ / "poses.txt").string()));
      return error.what();
    }
    ADD_FAILURE() << "accepted: " << text;
    return "";
  }
  void scans_at(std::initializer_list<double> seconds) {
    for (const double s : seconds) options_.row_times.push_back(Time::from_seconds(s));
  }

  TemporaryFolder folder_;
  TrajectoryFileOptions options_;
};

// Turned by 90 degrees about z: the sensor's x axis points along the world's y.
TEST_F(TrajectoryFile, ReadsTumRowsInTheirOrderAndToTheNanosecond) {
  const SampledTrajectory trajectory = read(
      "# t tx ty tz qx qy qz qw\n"
      "1317042272.283701593 1 2 3 0 0 0.70710678118654757 0.70710678118654757\r\n"
      "\n"
      "1.317042273283701594e+09\t1 2 3 0 0 0 1  # standing\n");
  ASSERT_EQ(trajectory.poses().size(), 2u);
  EXPECT_EQ(trajectory.poses()[0].time.nanoseconds(), 1'317'042'272'283'701'593);
  EXPECT_EQ(trajectory.poses()[1].time.nanoseconds(), 1'317'042'273'283'701'594);
  const SE3 T_0v = trajectory.poses()[0].T_v0.inverse();
  EXPECT_LT((T_0v * Eigen::Vector3d(10, 0, 0) - Eigen::Vector3d(1, 12, 3)).norm(), 1e-12);
}

TEST_F(TrajectoryFile, ReadsKittiRowsAtTheTimesOfTheScans) {
  scans_at({10, 10.1});
  const SampledTrajectory trajectory = read("0 -1 0 1  1 0 0 2  0 0 1 3\n" + std::string(kIdentityRow));
  EXPECT_EQ(trajectory.poses()[1].time, Time::from_seconds(10.1));
  const SE3 T_0v = trajectory.poses()[0].T_v0.inverse();
  EXPECT_LT((T_0v * Eigen::Vector3d(10, 0, 0) - Eigen::Vector3d(1, 12, 3)).norm(), 1e-12);
}

TEST_F(TrajectoryFile, UsesTheStatedDirection) {
  const std::string text = "0 1 2 3 0 0 0.70710678118654757 0.70710678118654757\n1 1 2 3 0 0 0 1\n";
  const SE3 T_0v = read(text).poses()[0].T_v0.inverse();
  options_.direction = PoseDirection::sensor_from_world;
  EXPECT_LT(pose_difference(read(text).poses()[0].T_v0, T_0v), 1e-12);
}

// A camera looks along z with x to the right. A car that drives 5 m ahead moves the camera by 5 m along z;
// the sensor, x ahead, by 5 m along x; a turn to the left is about -y for the camera, about z for the sensor.
TEST_F(TrajectoryFile, ConvertsCameraPosesToSensorPoses) {
  scans_at({0, 1, 2});
  Eigen::Matrix3d C_cam_sensor;
  C_cam_sensor << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  options_.T_file_sensor = SE3(C_cam_sensor, {0, -0.08, -0.27});
  const std::string identity = kIdentityRow;
  const SampledTrajectory trajectory =
      read(identity + "1 0 0 0 0 1 0 0 0 0 1 5\n" + "0 0 -1 0  0 1 0 0  1 0 0 0\n");
  EXPECT_LT(trajectory.poses()[0].T_v0.log().norm(), 1e-12);
  const SE3 ahead = trajectory.poses()[1].T_v0.inverse();
  EXPECT_LT((ahead * Eigen::Vector3d::Zero() - Eigen::Vector3d(5, 0, 0)).norm(), 1e-12);
  const SE3 left = trajectory.poses()[2].T_v0.inverse();
  EXPECT_LT((left.rotation() * Eigen::Vector3d::UnitX() - Eigen::Vector3d::UnitY()).norm(), 1e-12);
  // The same poses given the other way round.
  options_.direction = PoseDirection::sensor_from_world;
  const SampledTrajectory inverse =
      read(identity + "1 0 0 0 0 1 0 0 0 0 1 -5\n" + "0 0 1 0  0 1 0 0  -1 0 0 0\n");
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_LT(pose_difference(inverse.poses()[i].T_v0, trajectory.poses()[i].T_v0), 1e-12) << i;
  }
}

TEST_F(TrajectoryFile, ExtrapolatesAsFarAsAllowed) {
  options_.max_extrapolation = Duration::from_seconds(0.05);
  const SampledTrajectory trajectory = read("1 0 0 0 0 0 0 1\n2 4 0 0 0 0 0 1\n");
  EXPECT_EQ(trajectory.begin(), Time::from_seconds(0.95));
  EXPECT_EQ(trajectory.end(), Time::from_seconds(2.05));
  const SE3 T_0v = trajectory.at(Time::from_seconds(2.05)).T_v0.inverse();
  EXPECT_NEAR(T_0v.translation().x(), 4.2, 1e-12);
}

TEST_F(TrajectoryFile, RefusesBadQuaternions) {
  EXPECT_THAT(
      refusal("0 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 0\n"),
      AllOf(HasSubstr("poses.txt:2"), HasSubstr("pose row 1, quaternion = 0 0 0 0"), HasSubstr("norm 0")));
  EXPECT_THAT(refusal("0 0 0 0 0 0 0 1.1\n1 0 0 0 0 0 0 1\n"), HasSubstr("norm 1.1"));
}

TEST_F(TrajectoryFile, RefusesTextThatIsNotAFiniteNumber) {
  EXPECT_THAT(refusal("0 0 nan 0 0 0 0 1\n1 0 0 0 0 0 0 1\n"),
              AllOf(HasSubstr("pose row 0, number 3 = nan"), HasSubstr("finite")));
  EXPECT_THAT(refusal("0 0 0 0 0 0 0 1\ninf 0 0 0 0 0 0 1\n"), HasSubstr("number 1 = inf"));
  EXPECT_THAT(refusal("0 0 0 0 0 0 0 1\n1 0 0 0 0 x 0 1\n"),
              AllOf(HasSubstr("number 6 = x"), HasSubstr("not a number")));
  EXPECT_THAT(refusal("1e300 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 1\n"), HasSubstr("126 years"));
}

TEST_F(TrajectoryFile, RefusesRowsOfAnotherLength) {
  EXPECT_THAT(refusal("0 0 0 0 0 0 0 1\n1 0 0 0 0 0 0\n"),
              AllOf(HasSubstr("poses.txt:2"), HasSubstr("7 numbers")));
  EXPECT_THAT(refusal("0 0 0 0 0 0 0 1\n" + std::string(kIdentityRow)), HasSubstr("12 numbers"));
  EXPECT_THAT(refusal("1 2 3\n"), AllOf(HasSubstr("3 numbers"), HasSubstr("TUM"), HasSubstr("KITTI")));
}

TEST_F(TrajectoryFile, RefusesTimesThatDoNotIncrease) {
  EXPECT_THAT(
      refusal("0 0 0 0 0 0 0 1\n0.5 0 0 0 0 0 0 1\n0.25 0 0 0 0 0 0 1\n"),
      AllOf(HasSubstr("poses.txt:3"), HasSubstr("pose row 2, time = 0.25"), HasSubstr("0.500000000")));
  EXPECT_THAT(refusal("# comment\n7 0 0 0 0 0 0 1\n7.0000000001 0 0 0 0 0 0 1\n"),
              AllOf(HasSubstr("poses.txt:3"), HasSubstr("pose row 1, time")));
}

TEST_F(TrajectoryFile, RefusesANumberOfKittiRowsOtherThanThatOfTheScans) {
  scans_at({0, 0.1, 0.2});
  const std::string row = kIdentityRow;
  EXPECT_THAT(refusal(row + row),
              AllOf(HasSubstr("poses = 2"), HasSubstr("fewer poses than scans"), HasSubstr("3 scans")));
  EXPECT_THAT(refusal(row + row + row + row),
              AllOf(HasSubstr("poses = 4"), HasSubstr("more poses than scans")));
  EXPECT_NO_THROW((void)read(row + row + row));
}

TEST_F(TrajectoryFile, RefusesMatricesThatAreNotRotations) {
  scans_at({0, 0.1});
  const std::string row = kIdentityRow;
  EXPECT_THAT(refusal(row + "1 0 0 0 0 1 0 0 0 0 1.01 0\n"),
              AllOf(HasSubstr("poses.txt:2"), HasSubstr("pose row 1, matrix"), HasSubstr("not a rotation")));
  EXPECT_THAT(refusal(row + "1 0 0 0 0 1 0 0 0 0 -1 0\n"), HasSubstr("determinant is -1"));
  EXPECT_THAT(refusal("0 0 0 0 0 0 0 0 0 0 0 0\n" + row), HasSubstr("not a rotation"));
}

TEST_F(TrajectoryFile, RefusesEmptyAndMissingFilesAndSinglePoses) {
  EXPECT_THAT(refusal(""), HasSubstr("poses = 0"));
  EXPECT_THAT(refusal("# only a comment\n\n"), HasSubstr("poses = 0"));
  EXPECT_THAT(refusal("0 0 0 0 0 0 0 1\n"), HasSubstr("at least two"));
  EXPECT_THROW((void)read_trajectory_file(folder_ / "absent.txt", options_), InputError);
  EXPECT_THROW((void)read_trajectory_file(folder_.path(), options_), InputError);
}

TEST_F(TrajectoryFile, ReadsBackTheWrittenPoses) {
  for (unsigned seed = 0; seed < 5; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937 random(seed);
    std::vector<TimedPose> poses;
    options_.row_times.clear();
    for (int i = 0; i < 50; ++i) {
      const Time time = Time::from_nanoseconds(1'317'042'272'283'701'593 + i * 100'000'007LL);
      poses.push_back({time, SE3::exp(random_vector(random, 1e5, 3.1))});
      options_.row_times.push_back(time);
    }
    write_tum_trajectory(folder_ / "tum.txt", poses);
    write_kitti_poses(folder_ / "kitti.txt", poses);
    for (const char* name : {"tum.txt", "kitti.txt"}) {
      const SampledTrajectory back = read_trajectory_file(folder_ / name, options_);
      ASSERT_EQ(back.poses().size(), poses.size());
      for (std::size_t i = 0; i < poses.size(); ++i) {
        const SE3 T_0v = poses[i].T_v0.inverse(), T_0v_back = back.poses()[i].T_v0.inverse();
        EXPECT_EQ(back.poses()[i].time, poses[i].time);
        EXPECT_LT((T_0v_back.rotation() - T_0v.rotation()).norm(), 1e-12);
        EXPECT_LT((T_0v_back.translation() - T_0v.translation()).norm(), 1e-9);
      }
    }
  }
}

TEST_F(TrajectoryFile, WritersThrowIfTheyCannotWrite) {
  EXPECT_THROW(write_kitti_poses(folder_ / "no" / "poses.txt", {}), OutputError);
  EXPECT_THROW(write_tum_trajectory(folder_ / "no" / "poses.txt", {}), OutputError);
}

TEST_F(TrajectoryFile, ReadsARealDrive) {
  const auto date = test::shared_data("kitti_raw/2011_09_26");
  const auto file = date / "2011_09_26_drive_0005_sync" / "poses_icp.txt";
  MAPLESS_SKIP_WITHOUT(file);
  for (int k = 0; k < 50; ++k) options_.row_times.push_back(Time::from_seconds(0.1 * k));
  const SampledTrajectory trajectory = read_trajectory_file(file, options_);
  ASSERT_EQ(trajectory.poses().size(), 50u);
  // 3 to 7 m/s forward, by the note of the recording.
  for (int k = 0; k < 49; ++k) {
    const Vector6d varpi = trajectory.at(Time::from_seconds(0.1 * k + 0.05)).varpi;
    EXPECT_GT(-varpi[0], 2.5) << k;
    EXPECT_LT(-varpi[0], 7.5) << k;
  }
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
