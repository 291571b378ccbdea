#include <csignal>
#include <filesystem>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "support/command.hpp"
#include "support/temporary_folder.hpp"
#include "support/toy_sequence.hpp"
#include <mapless/io/files.hpp>
#include <mapless/io/trajectory_file.hpp>

namespace mapless {
namespace MAPLESS_FILE {

using test::run_command;
using testing::HasSubstr;

TEST(Odometry, WritesThePosesOfTheInstantAskedFor) {
  const test::TemporaryFolder folder;
  const test::ToyScene street = test::toy_street("VLP-16");
  test::write_toy_sequence(street, 8, folder / "street");
  for (const std::string instant : {"start", "middle", "end"}) {
    SCOPED_TRACE(instant);
    const std::string out = folder / instant;
    const auto r = run_command({"odometry", folder / "street", "-o", out, "--pose-instant", instant});
    ASSERT_EQ(r.exit_code, 0) << r.err;
    const auto poses = read_trajectory_file(out + "/trajectory.txt", {}).poses();
    ASSERT_EQ(poses.size(), 8u);
    const double after_start = instant == "start" ? 0 : instant == "middle" ? 0.05 : 0.1;
    const SE3 T_first = street.trajectory->at(cast_scan(street, 0).scan->start).T_v0;
    for (std::size_t k = 0; k < poses.size(); ++k) {
      EXPECT_NEAR(poses[k].time.seconds(), 0.1 * static_cast<double>(k) + after_start, 1e-4);
      const SE3 T_true = street.trajectory->at(poses[k].time).T_v0 * T_first.inverse();
      EXPECT_LT((poses[k].T_v0 * T_true.inverse()).log().head<3>().norm(), 0.1);
    }
    TrajectoryFileOptions rows;
    for (const TimedPose& pose : poses) rows.row_times.push_back(pose.time);
    const auto kitti = read_trajectory_file(out + "/poses_kitti.txt", rows).poses();
    EXPECT_LT((kitti[7].T_v0.matrix() - poses[7].T_v0.matrix()).norm(), 1e-6);
  }
}

TEST(Odometry, WritesSeveralPosesAScanWhereAsked) {
  const test::TemporaryFolder folder;
  test::write_toy_sequence(test::toy_street("VLP-16"), 6, folder / "street");
  const std::string out = folder / "out";
  const auto r = run_command({"odometry", folder / "street", "-o", out, "--poses-per-scan", "10", "--json"});
  ASSERT_EQ(r.exit_code, 0) << r.err;
  const auto rows = read_trajectory_file(out + "/trajectory.txt", {}).poses();
  ASSERT_EQ(rows.size(), 61u) << "ten a scan and the end of the last";
  EXPECT_NEAR(rows[10].time.seconds(), 0.1, 1e-4);
  EXPECT_NEAR(rows[15].time.seconds(), 0.15, 1e-4);
  EXPECT_NEAR(rows.back().time.seconds(), 0.6, 1e-4);
  TrajectoryFileOptions per_scan;
  for (std::size_t k = 0; k < 6; ++k) per_scan.row_times.push_back(rows[10 * k].time);
  EXPECT_EQ(read_trajectory_file(out + "/poses_kitti.txt", per_scan).poses().size(), 6u);
  const auto summary = nlohmann::json::parse(r.out);
  EXPECT_EQ(summary["scans"], 6);
  EXPECT_EQ(summary["poses"], 61);
  EXPECT_GT(summary["scan_ms"]["median"], 0.0);
}

// Scan 7 is scan 6 once more: as in `detect`, that is said, and the poses are not trusted.
TEST(Odometry, SaysWhichScansContradict) {
  const test::TemporaryFolder folder;
  const std::filesystem::path scans = folder / "street/scans";
  test::write_toy_sequence(test::toy_street("VLP-16"), 12, folder / "street");
  std::filesystem::copy_file(scans / "000006.pcd", scans / "000007.pcd",
                             std::filesystem::copy_options::overwrite_existing);
  const auto r = run_command({"odometry", folder / "street", "-o", folder / "out", "--json"});
  EXPECT_EQ(r.exit_code, 4);
  EXPECT_THAT(r.err, HasSubstr("doubtful scans: scan 7"));
  EXPECT_THAT(nlohmann::json::parse(r.out)["doubts"].dump(), HasSubstr("doubtful scans: scan 7"));
}

TEST(Odometry, ReplacesPosesOnlyWhenAsked) {
  const test::TemporaryFolder folder;
  test::write_toy_sequence(test::toy_street("VLP-16"), 6, folder / "street");
  const std::string out = folder / "out";
  EXPECT_EQ(run_command({"odometry", folder / "street", "-o", out}).exit_code, 0);
  const auto r = run_command({"odometry", folder / "street", "-o", out});
  EXPECT_EQ(r.exit_code, 1);
  EXPECT_THAT(r.err, HasSubstr("--overwrite"));
  EXPECT_EQ(run_command({"odometry", folder / "street", "-o", out, "--overwrite"}).exit_code, 0);
}

TEST(Odometry, OverwritesNothingButItsOwnPoses) {
  const test::TemporaryFolder folder;
  test::write_toy_sequence(test::toy_street("VLP-16"), 6, folder / "street");
  const std::filesystem::path truth = folder / "street/trajectory.txt";
  const std::string before = read_whole_file(truth);
  const auto r = run_command({"odometry", folder / "street", "-o", folder / "street", "--overwrite"});
  EXPECT_EQ(r.exit_code, 1);
  EXPECT_THAT(r.err, testing::AllOf(HasSubstr(folder / "street"), HasSubstr("nothing in it is overwritten")));
  EXPECT_EQ(read_whole_file(truth), before);
  for (const char* name : {"summary.json", "trajectory.txt", "poses_kitti.txt"}) {
    write_file_atomically(folder / "street" / name, "of a detection");
  }
  EXPECT_EQ(run_command({"odometry", folder / "street", "-o", folder / "street", "--overwrite"}).exit_code,
            1);
  EXPECT_EQ(read_whole_file(truth), "of a detection");
  std::filesystem::create_directory(folder / "mine");
  write_file_atomically(folder / "mine/notes", "mine");
  for (const std::string option : {"--overwrite", "--resume"}) {
    const auto mine = run_command({"odometry", folder / "street", "-o", folder / "mine", option});
    EXPECT_EQ(mine.exit_code, 1) << option << mine.err;
    EXPECT_FALSE(std::filesystem::exists(folder / "mine/trajectory.txt"));
  }
}

TEST(Odometry, ThatItCannotWriteIsKnownBeforeTheWork) {
  const test::TemporaryFolder folder;
  write_file_atomically(folder / "file", "");
  const auto r = run_command({"odometry", folder / "none", "-o", folder / "file/out"});
  EXPECT_EQ(r.exit_code, 1);
  EXPECT_THAT(r.err, testing::AllOf(HasSubstr("file"), HasSubstr("not a folder;")));
}

TEST(Odometry, InterruptedInItsStartUpItWritesNothing) {
  const test::TemporaryFolder folder;
  test::write_toy_sequence(test::toy_street("VLP-16"), 40, folder / "street");
  test::RunningCommand command({"odometry", folder / "street", "-o", folder / "out", "--threads", "1"});
  ASSERT_TRUE(command.wait_for_error_line("1 of 40 scans"));
  command.send(SIGINT);
  const auto r = command.wait();
  EXPECT_EQ(r.exit_code, 130) << r.err;
  EXPECT_THAT(r.err, HasSubstr("nothing is written"));
  EXPECT_FALSE(std::filesystem::exists(folder / "out"));
}

TEST(Odometry, TakesMeasurementsOfOtherSensors) {
  const test::TemporaryFolder folder;
  test::write_toy_sequence(test::toy_street("VLP-16"), 8, folder / "street");  // 8 m/s
  const std::string speeds = folder / "speeds.csv", turns = folder / "turns.csv";
  write_file_atomically(speeds, "time_s,speed_m_s\n0.05,8\n0.45,8\n");
  write_file_atomically(turns, "time_s,x_rad_s,y_rad_s,z_rad_s\n0.05,0,0,0\n");
  const auto run_with = [&](const std::vector<std::string>& options, const std::string& out) {
    std::vector<std::string> arguments = {"odometry", folder / "street", "-o", folder / out};
    arguments.insert(arguments.end(), options.begin(), options.end());
    return run_command(arguments);
  };
  ASSERT_EQ(run_with({}, "without").exit_code, 0);
  const std::string without = read_whole_file(folder / "without/trajectory.txt");
  for (const auto& options :
       {std::vector<std::string>{"--initial-velocity=8,0,0"}, {"--speed", speeds}, {"--imu", turns}}) {
    const std::string out = options[0].substr(0, 9);
    const auto r = run_with(options, out);
    EXPECT_EQ(r.exit_code, 0) << r.err;
    EXPECT_NE(read_whole_file(folder / (out + "/trajectory.txt")), without) << options[0];
  }
  // A speed that the scans contradict, and one of another clock.
  write_file_atomically(speeds, "time_s,speed_m_s\n0.75,30\n");
  EXPECT_EQ(run_with({"--speed", speeds}, "wrong").exit_code, 4);
  write_file_atomically(speeds, "time_s,speed_m_s\n1700000000,8\n");
  const auto r = run_with({"--speed", speeds}, "clock");
  EXPECT_EQ(r.exit_code, 3);
  EXPECT_THAT(r.err, testing::AllOf(HasSubstr(speeds), HasSubstr("clock of the scans")));
  EXPECT_EQ(run_with({"--initial-velocity=8,0"}, "two").exit_code, 2);
}

// The pose of every point is needed, and a compensated point has lost it.
TEST(Odometry, OfCompensatedPointsNamesTheScan) {
  const test::TemporaryFolder folder;
  const std::string recording = folder / "kitti", out = folder / "out";
  ASSERT_EQ(run_command({"simulate", "crossing", "--sensor", "VLP-16", "--format", "kitti", "--duration-s",
                         "0.3", "-o", recording})
                .exit_code,
            0);
  for (const auto& verb : {std::vector<std::string>{"odometry"}, {"detect", "--odometry"}}) {
    std::vector<std::string> arguments = verb;
    arguments.insert(arguments.end(), {recording, "-o", out});
    const auto r = run_command(arguments);
    EXPECT_EQ(r.exit_code, 3);
    EXPECT_THAT(r.err,
                testing::AllOf(HasSubstr("velodyne/000000.bin"), HasSubstr("mapless detect --trajectory")));
  }
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
