#include <algorithm>
#include <csignal>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "support/command.hpp"
#include "support/temporary_folder.hpp"
#include "support/toy_sequence.hpp"
#include <mapless/io/dataset.hpp>
#include <mapless/io/files.hpp>
#include <mapless/io/result_folder.hpp>
#include <mapless/io/trajectory_file.hpp>
#include <mapless/odometry/lidar_odometry.hpp>

namespace mapless {
namespace MAPLESS_FILE {

namespace fs = std::filesystem;
using test::run_command;
using testing::HasSubstr;

constexpr int kScans = 24;
const std::vector<std::string> kTables = {"poses_kitti.txt", "trajectory.txt", "poses.csv", "config.yaml"};

std::size_t rows_of(const fs::path& file) {
  const std::string text = read_whole_file(file);
  return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
}

// One run, to its end, of ten poses a scan.
class OdometryResumeTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    shared = new test::TemporaryFolder;  // NOLINT: lives as long as the suite
    test::write_toy_sequence(with_columns(test::toy_street("VLP-16"), 600), kScans, street());
    ASSERT_EQ(run_command(arguments(*shared / "one", {})).exit_code, 0);
  }
  static void TearDownTestSuite() { delete shared; }  // NOLINT

  [[nodiscard]] static std::string street() { return *shared / "street"; }
  static std::vector<std::string> arguments(const std::string& output, const std::vector<std::string>& more) {
    std::vector<std::string> out = {"odometry", street(), "-o", output, "--poses-per-scan", "10"};
    out.insert(out.end(), more.begin(), more.end());
    return out;
  }
  // Ends a run by `signal` once it says that `scans` are processed.
  void end_run(int signal, int scans, const std::string& option) const {
    test::RunningCommand command(arguments(folder / "out", {option}));
    command.wait_for_error_line(std::to_string(scans) + " of " + std::to_string(kScans) + " scans");
    command.send(signal);
    (void)command.wait();
  }
  void expect_same_bytes() const {
    for (const std::string& file : kTables)
      EXPECT_EQ(read_whole_file(folder / ("out/" + file)), read_whole_file(*shared / ("one/" + file)))
          << file;
  }

  static inline test::TemporaryFolder* shared = nullptr;
  test::TemporaryFolder folder;
};

// Poses are written before the last scan, and are those of the trajectory after it.
TEST_F(OdometryResumeTest, PosesWrittenScanByScanAreFinal) {
  LidarOdometry odometry;
  const auto dataset = open_dataset(street());
  for (std::size_t k = 0; k < dataset->size(); ++k)
    (void)odometry.process(std::make_shared<const LidarScan>(dataset->read(k)));
  for (const std::string instant : {"start", "middle", "end"}) {
    const std::string out = folder / instant;
    ASSERT_EQ(run_command(arguments(out, {"--pose-instant", instant})).exit_code, 0);
    const auto rows = read_trajectory_file(out + "/trajectory.txt", {}).poses();
    EXPECT_GE(rows.size(), 10u * kScans - 9);
    for (const TimedPose& row : rows)
      EXPECT_LT((row.T_v0.matrix() - odometry.trajectory().at(row.time).T_v0.matrix()).norm(), 1e-8)
          << instant << row.time.seconds();
  }
}

TEST_F(OdometryResumeTest, AKilledRunKeepsThePosesOfTheScansThatAreSettled) {
  end_run(SIGKILL, 20, "--overwrite");
  const ResultFolder result(folder / "out");
  ASSERT_TRUE(fs::exists(result.poses()));
  // Its head; four scans are open, four wait to be written, one is being written.
  EXPECT_GE(rows_of(result.poses()), 1u + 20 - 9);
  EXPECT_GE(rows_of(result.kitti_poses()), rows_of(result.poses()) - 1);
  EXPECT_EQ(nlohmann::json::parse(read_whole_file(result.summary()))["complete"], false);
  const auto evaluated = run_command({"evaluate", street(), folder / "out"});
  EXPECT_NE(evaluated.exit_code, 0) << "the run was ended before its last scan";
}

TEST_F(OdometryResumeTest, AfterAKillAtAnyInstantTheResultIsThatOfOneRun) {
  const unsigned seed = std::random_device{}();
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random(seed);
  for (const int signal : {SIGKILL, SIGINT}) {
    fs::remove_all(folder / "out");
    end_run(signal, 8 + static_cast<int>(random() % 8), "--overwrite");
    end_run(signal, 14 + static_cast<int>(random() % 8), "--resume");
    const auto r = run_command(arguments(folder / "out", {"--resume"}));
    EXPECT_EQ(r.exit_code, 0) << r.err;
    expect_same_bytes();
  }
  const auto complete = run_command(arguments(folder / "out", {"--resume"}));
  EXPECT_EQ(complete.exit_code, 0);
  EXPECT_THAT(complete.err, HasSubstr("is complete"));
}

TEST_F(OdometryResumeTest, IsRefusedWhereTheRunWouldDifferOrAFileHasChanged) {
  fs::copy(*shared / "one", folder / "out", fs::copy_options::recursive);
  const ResultFolder result(folder / "out");
  std::string summary = read_whole_file(result.summary());
  summary.replace(summary.find("\"complete\": true"), 16, "\"complete\": false");
  write_file_atomically(result.summary(), summary);
  const auto instant = run_command(arguments(folder / "out", {"--resume", "--pose-instant", "end"}));
  EXPECT_EQ(instant.exit_code, 2);
  EXPECT_THAT(instant.err, HasSubstr("pose_instant"));
  const auto measured = run_command(arguments(folder / "out", {"--resume", "--initial-velocity", "3,0,0"}));
  EXPECT_EQ(measured.exit_code, 2);
  EXPECT_THAT(measured.err, HasSubstr("recording_digest"));

  std::string poses = read_whole_file(result.kitti_poses());
  poses[10] = poses[10] == '1' ? '2' : '1';
  write_file_atomically(result.kitti_poses(), poses);
  const auto changed = run_command(arguments(folder / "out", {"--resume"}));
  EXPECT_EQ(changed.exit_code, 3);
  EXPECT_THAT(changed.err, HasSubstr("poses_kitti.txt"));
  EXPECT_EQ(read_whole_file(result.kitti_poses()), poses) << "nothing is touched";
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
