#include <filesystem>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/command.hpp"
#include "support/temporary_folder.hpp"
#include "support/toy_sequence.hpp"
#include <mapless/io/files.hpp>
#include <mapless/io/labels.hpp>
#include <mapless/io/result_folder.hpp>

namespace mapless {
namespace MAPLESS_FILE {

namespace fs = std::filesystem;
using test::run_command;
using testing::HasSubstr;

constexpr int kScans = 12;

const SE3& T_roof_bumper() {
  static const SE3 T(so3_exp({0.02, 0.1, 0.3}), {1.5, 0.2, -0.9});
  return T;
}

// A street seen from the roof and the bumper of one car.
class RigTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    shared = new test::TemporaryFolder;  // NOLINT: lives as long as the suite
    test::ToyScene street = with_columns(test::toy_street("VLP-16"), 400);
    test::write_toy_sequence(street, kScans, *shared / "rig" / "roof");
    street.trajectory =
        std::make_shared<const MountedTrajectory>(street.trajectory, T_roof_bumper().inverse());
    test::write_toy_sequence(street, kScans, *shared / "rig" / "bumper");
    write_rig_yaml(*shared / "rig" / "rig.yaml",
                   {{"roof", SE3(), {}, ""}, {"bumper", T_roof_bumper(), {}, ""}});
    fs::create_directories(fs::path(*shared / "single"));
    fs::create_directory_symlink(*shared / "rig" / "roof", *shared / "single" / "roof");
    write_rig_yaml(*shared / "single" / "rig.yaml", {{"roof", T_roof_bumper(), {}, ""}});
  }
  static void TearDownTestSuite() { delete shared; }  // NOLINT

  static inline test::TemporaryFolder* shared = nullptr;
  test::TemporaryFolder folder;
};

TEST_F(RigTest, EverySensorGetsAResultOfItsOwn) {
  for (const char* motion : {"--causal", "--odometry"}) {  // along given poses, and estimated ones
    const std::string out = folder / motion;
    const auto run = run_command({"detect", *shared / "rig", "-o", out, motion, "--probability"});
    ASSERT_EQ(run.exit_code, 0) << run.err;
    for (const char* sensor : {"roof", "bumper"}) {
      const ResultFolder result(fs::path(out) / sensor);
      EXPECT_EQ(result.labelled_scans().size(), static_cast<std::size_t>(kScans));
      EXPECT_THAT(read_whole_file(result.summary()), HasSubstr("\"complete\": true"));
      EXPECT_TRUE(fs::exists(result.probability_file(kScans - 1)));
      const auto evaluated =
          run_command({"evaluate", *shared / "rig" / sensor, (fs::path(out) / sensor).string()});
      EXPECT_EQ(evaluated.exit_code, 0) << evaluated.err;
    }
    EXPECT_EQ(fs::exists(fs::path(out) / "roof" / "poses.csv"), std::string(motion) == "--odometry");
    EXPECT_FALSE(fs::exists(fs::path(out) / "bumper" / "poses.csv"));
  }
}

TEST_F(RigTest, OneSensorAloneGivesTheBytesOfItsOwnRecording) {
  ASSERT_EQ(run_command({"detect", *shared / "single", "-o", folder / "rig"}).exit_code, 0);
  ASSERT_EQ(run_command({"detect", *shared / "rig" / "roof", "-o", folder / "alone"}).exit_code, 0);
  const fs::path alone = folder / "alone", rig = fs::path(folder / "rig") / "roof";
  for (const char* name : {"objects.csv", "trajectory.txt", "poses_kitti.txt", "config.yaml",
                           "labels/000007.label", "labels/000011.label", "stages/000007.stages"})
    EXPECT_EQ(read_whole_file(rig / name), read_whole_file(alone / name)) << name;
}

// A quarter turn in the bumper's place: along the poses of the roof it would drive sideways.
TEST_F(RigTest, APlaceThatTheScansContradictIsNotTrusted) {
  const fs::path rig = fs::path(folder / "rig");
  fs::create_directories(rig);
  for (const char* sensor : {"roof", "bumper"})
    fs::create_directory_symlink(*shared / "rig" / sensor, rig / sensor);
  const SE3 turned(so3_exp({0, 0, std::numbers::pi / 2}), T_roof_bumper().translation());
  write_rig_yaml(rig / "rig.yaml", {{"roof", SE3(), {}, ""}, {"bumper", turned, {}, ""}});
  const auto run = run_command({"detect", rig.string(), "-o", folder / "out"});
  EXPECT_EQ(run.exit_code, 3) << run.err;
  EXPECT_THAT(run.err, HasSubstr("bumper"));
  EXPECT_FALSE(fs::exists(folder / "out"));
}

// The driver of the bumper has stalled.
TEST_F(RigTest, EveryScanOfEverySensorIsWatched) {
  const fs::path rig = fs::path(folder / "rig");
  fs::copy(*shared / "rig", rig, fs::copy_options::recursive);
  fs::copy_file(rig / "bumper" / "scans" / "000006.pcd", rig / "bumper" / "scans" / "000007.pcd",
                fs::copy_options::overwrite_existing);
  const auto run = run_command({"detect", rig.string(), "-o", folder / "out", "--odometry"});
  EXPECT_EQ(run.exit_code, 4) << run.err;
  EXPECT_THAT(run.err, HasSubstr("bumper: doubtful scans: scan 7: the same points as the scan before"));
  EXPECT_THAT(run.err, testing::Not(HasSubstr("roof: doubtful")));
}

TEST_F(RigTest, OptionsOfOneRecordingAreRefused) {
  const auto run = run_command({"detect", *shared / "rig", "-o", folder / "out", "--first", "3"});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.err, HasSubstr("--first"));
  EXPECT_FALSE(fs::exists(folder / "out"));
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
