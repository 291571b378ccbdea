#include <algorithm>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "io/formats/mdlidar/mdlidar_writer.hpp"
#include "support/command.hpp"
#include "support/temporary_folder.hpp"
#include "support/toy_sequence.hpp"
#include <mapless/io/dataset.hpp>
#include <mapless/io/files.hpp>
#include <mapless/io/labels.hpp>
#include <mapless/io/result_folder.hpp>
#include <mapless/io/trajectory_file.hpp>

namespace mapless {
namespace MAPLESS_FILE {

namespace fs = std::filesystem;
using test::CommandResult;
using test::run_command;
using testing::HasSubstr;

constexpr int kScans = 12;

// One small street for all tests, which only read it; each has an output folder of its own.
class DetectTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    shared = new test::TemporaryFolder;  // NOLINT: lives as long as the suite
    test::write_toy_sequence(test::toy_street("VLP-16"), kScans, *shared / "street");
  }
  static void TearDownTestSuite() { delete shared; }  // NOLINT

  [[nodiscard]] static std::string street() { return *shared / "street"; }
  [[nodiscard]] std::string out() const { return folder / "out"; }
  [[nodiscard]] ResultFolder result() const { return ResultFolder(out()); }
  [[nodiscard]] nlohmann::json summary() const {
    return nlohmann::json::parse(read_whole_file(result().summary()));
  }
  CommandResult detect(const std::vector<std::string>& more, const std::string& recording = street()) const {
    std::vector<std::string> arguments = {"detect", recording, "-o", out()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_command(arguments);
  }
  // A copy of the street that a test may break.
  [[nodiscard]] std::string street_copy() const {
    fs::copy(street(), folder / "copy", fs::copy_options::recursive);
    return folder / "copy";
  }
  std::string pose_rows(int rows) const {
    std::string text;
    for (int k = 0; k < rows; ++k) text += "1 0 0 " + std::to_string(0.8 * k) + " 0 1 0 0 0 0 1 0\n";
    write_file_atomically(folder / "poses.txt", text);
    return folder / "poses.txt";
  }
  void expect_error(const CommandResult& r, int exit_code, const std::vector<std::string>& parts) const {
    EXPECT_EQ(r.exit_code, exit_code) << r.err;
    const std::size_t at = r.err.find("mapless: error: ");
    ASSERT_NE(at, std::string::npos) << r.err;
    EXPECT_EQ(std::count(r.err.begin() + static_cast<std::ptrdiff_t>(at), r.err.end(), '\n'), 1) << r.err;
    for (const std::string& part : parts) EXPECT_THAT(r.err, HasSubstr(part));
  }

  static inline test::TemporaryFolder* shared = nullptr;
  test::TemporaryFolder folder;
};

std::vector<fs::path> files_in(const fs::path& root) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(root)) {
    if (entry.is_regular_file()) files.push_back(fs::relative(entry.path(), root));
  }
  std::sort(files.begin(), files.end());
  return files;
}

// A turn of two lasers that meet nothing, 1 m ahead of the turn before.
MdlidarFrame empty_frame(int k) {
  constexpr std::int64_t kTurn_ns = 100'000'000;
  MdlidarFrame frame;
  frame.start = Time::from_nanoseconds(k * kTurn_ns);
  frame.end = frame.start + Duration::from_nanoseconds(kTurn_ns);
  frame.pose_p = SE3(Eigen::Matrix3d::Identity(), {static_cast<double>(k), 0, 0});
  frame.pose = SE3(Eigen::Matrix3d::Identity(), {k + 1.0, 0, 0});
  for (int laser = 0; laser < 2; ++laser) {
    for (int c = 0; c < 90; ++c) {
      MdlidarPoint point;
      point.rotation_deg = static_cast<float>((180 + 4 * c) % 360);
      frame.points.push_back(point);
    }
  }
  return frame;
}

TEST_F(DetectTest, WritesALabelForEveryRecordOfEveryScan) {
  ASSERT_EQ(detect({}).exit_code, 0);
  const auto dataset = open_dataset(street());
  std::size_t dynamic = 0;
  for (std::size_t k = 0; k < kScans; ++k) {
    const LidarScan scan = dataset->read(k);
    const auto labels = read_label_file(result().label_file(k), scan.input_size);
    const auto stages = read_stage_file(result().stage_file(k), scan.input_size);
    std::vector<bool> is_return(scan.input_size, false);
    for (const LidarReturn& r : scan.returns) is_return[r.input_index] = true;
    for (std::size_t i = 0; i < labels.size(); ++i) {
      const bool moving = motion_of_label(labels[i]) == MotionTruth::moving;
      ASSERT_EQ(labels[i] != 0, is_return[i]);
      ASSERT_EQ(moving, (stages[i] >> 4 & 1) == 1);
      ASSERT_EQ(labels[i] >> 16 != 0, moving);
      dynamic += moving ? 1 : 0;
    }
  }
  EXPECT_GT(dynamic, 0u);
  EXPECT_EQ(summary()["dynamic_points"], dynamic);
}

TEST_F(DetectTest, SummaryTellsWhatWasReadAndUsed) {
  const CommandResult r = detect({"--json", "--causal"});
  ASSERT_EQ(r.exit_code, 0) << r.err;
  const auto s = summary();
  EXPECT_EQ(nlohmann::json::parse(r.out), s);
  EXPECT_EQ(s["complete"], true);
  EXPECT_EQ(s["format"], "native");
  EXPECT_EQ(s["scans"], kScans);
  EXPECT_EQ(s["trajectory"]["source"], "recording");
  for (const char* row : {"compensation", "comparison", "backward", "forward", "evidence", "filter",
                          "region_growth", "total"}) {
    EXPECT_GE(s["timing"][row]["median_ms"], 0.0) << row;
    EXPECT_LE(s["timing"][row]["median_ms"], s["timing"][row]["p95_ms"]) << row;
    EXPECT_LE(s["timing"][row]["p95_ms"], s["timing"][row]["p99_ms"]) << row;
  }
  EXPECT_EQ(s["timing"]["forward"]["p99_ms"], 0.0) << "causal: no forward check";
  EXPECT_GT(s["peak_memory_mb"], 0.0);
  for (const char* side : {"reading", "writing"}) {
    const auto& row = s["input_output"][side];
    EXPECT_GT(row["busy_s"], 0.0) << side;
    EXPECT_LE(row["waited_s"], s["input_output"]["run_s"]) << side;
    EXPECT_NEAR(row["waited_share"].get<double>() * s["input_output"]["run_s"].get<double>(), row["waited_s"],
                1e-9);
  }
  EXPECT_FALSE(s.contains("real_time"));
}

TEST_F(DetectTest, ConfigurationOfAResultReadsBack) {
  ASSERT_EQ(detect({"--profile", "paper", "--set", "scan_gap=2", "--count", "3"}).exit_code, 0);
  const CommandResult printed = run_command({"config", "--config", result().config()});
  EXPECT_EQ(printed.exit_code, 0) << printed.err;
  EXPECT_EQ(printed.out, read_whole_file(result().config()));
  EXPECT_THAT(printed.out, HasSubstr("scan_gap: 2\n"));
}

TEST_F(DetectTest, PosesComeOutAsTheyWentIn) {
  ASSERT_EQ(detect({"--first", "2", "--count", "5"}).exit_code, 0);
  const test::ToyScene scene = test::toy_street("VLP-16");
  const SampledTrajectory found = read_trajectory_file(result().trajectory(), {});
  ASSERT_EQ(found.poses().size(), 51u) << "ten in each of five scans and the last end";
  for (std::size_t i = 0; i < 51; ++i) {
    const Time t = Time::from_nanoseconds(200'000'000 + 10'000'000LL * static_cast<long long>(i));
    // A column is a whole number of nanoseconds, and a turn has fewer than 2,000 of them.
    EXPECT_NEAR((found.poses()[i].time - t).seconds(), 0, 2e-6);
    EXPECT_LT((found.poses()[i].T_v0 * scene.trajectory->at(t).T_v0.inverse()).log().norm(), 1e-3);
  }
  const std::string rows = read_whole_file(result().kitti_poses());
  EXPECT_EQ(std::count(rows.begin(), rows.end(), '\n'), 5);
  EXPECT_EQ(result().labelled_scans(), (std::vector<std::size_t>{2, 3, 4, 5, 6}));
}

TEST_F(DetectTest, TheSameBytesForAnyNumberOfThreads) {
  ASSERT_EQ(detect({"--threads", "1"}).exit_code, 0);
  const std::string other = folder / "other";
  ASSERT_EQ(run_command({"detect", street(), "-o", other, "--threads", "3"}).exit_code, 0);
  const auto files = files_in(out());
  EXPECT_EQ(files, files_in(other));
  for (const fs::path& file : files) {
    if (file == "summary.json") continue;  // has the times
    EXPECT_EQ(read_whole_file(fs::path(out()) / file), read_whole_file(fs::path(other) / file)) << file;
  }
}

TEST_F(DetectTest, IsEvaluatedAndDrawn) {
  ASSERT_EQ(detect({}).exit_code, 0);
  const CommandResult table = run_command({"evaluate", street(), out(), "--json", folder / "e.json"});
  ASSERT_EQ(table.exit_code, 0) << table.err;
  EXPECT_THAT(table.out,
              testing::AllOf(HasSubstr("N_p"), HasSubstr("past evidence"), HasSubstr("12 scans evaluated")));
  const auto e = nlohmann::json::parse(read_whole_file(folder / "e.json"));
  EXPECT_EQ(e["stages"].size(), 5u);
  EXPECT_EQ(e["final"]["tp"], e["stages"][4]["tp"]);
  EXPECT_GT(e["final"]["tp"], 0);
  const CommandResult picture =
      run_command({"render", street(), out(), "--scan", "9", "-o", folder / "x.png"});
  ASSERT_EQ(picture.exit_code, 0) << picture.err;
  EXPECT_THAT(read_whole_file(folder / "x.png"), testing::StartsWith("\x89PNG"));
  expect_error(run_command({"render", street(), out(), "--scan", "12", "-o", folder / "y.png"}), 2,
               {"--scan", "12"});
}

TEST_F(DetectTest, EvaluatesFoldersThatHaveLabelsOnly) {
  ASSERT_EQ(detect({"--causal", "--count", "2"}).exit_code, 0);
  fs::remove_all(result().stages());
  const CommandResult r = run_command({"evaluate", street(), out(), "--json", "-"});
  ASSERT_EQ(r.exit_code, 0) << r.err;
  const auto e = nlohmann::json::parse(r.out);
  EXPECT_TRUE(e["stages"].empty());
  EXPECT_TRUE(e["final"]["precision"].is_null())
      << "with no reference and a gap of one scan nothing is dynamic";
}

TEST_F(DetectTest, InfoTellsOfOddities) {
  const std::string copy = street_copy();
  fs::copy_file(copy + "/scans/000003.pcd", copy + "/scans/000007.pcd", fs::copy_options::overwrite_existing);
  const CommandResult r = run_command({"info", copy, "--json"});
  ASSERT_EQ(r.exit_code, 0) << r.err;
  const auto info = nlohmann::json::parse(r.out);
  EXPECT_EQ(info["scans"], kScans);
  EXPECT_EQ(info["labels"]["scans"], kScans);
  EXPECT_THAT(info["oddities"].dump(), HasSubstr("scan 7: the same bytes as scan 3"));
}

TEST_F(DetectTest, InfoTellsHowWellAnEstimatedSensorFits) {
  const std::string bare = folder / "bare";  // without its sensor.yaml
  fs::copy(street() + "/scans", bare);
  fs::copy_file(street() + "/times.txt", bare + "/times.txt");
  const CommandResult text = run_command({"info", bare});
  ASSERT_EQ(text.exit_code, 0) << text.err;
  EXPECT_THAT(text.out, testing::ContainsRegex("residual [0-9]\\.[0-9][0-9] mm in elevation"));
  const CommandResult json = run_command({"info", bare, "--json"});
  ASSERT_EQ(json.exit_code, 0) << json.err;
  const auto sensor = nlohmann::json::parse(json.out)["sensor"];
  EXPECT_EQ(sensor["lasers"], 16);
  // The street's points lie on their beams, but for the rounding of floats.
  EXPECT_LT(sensor["estimate"]["elevation_residual_m"].get<double>(), 0.001);
}

TEST_F(DetectTest, InfoTellsWhichScanTheTrajectoryDoesNotReach) {
  const std::string copy = street_copy();
  write_file_atomically(copy + "/trajectory.txt", "0 0 0 0 0 0 0 1\n0.75 6 0 0 0 0 0 1\n");
  const CommandResult r = run_command({"info", copy});
  EXPECT_EQ(r.exit_code, 0) << r.err;
  EXPECT_THAT(r.out, HasSubstr("scan 7 = [0.700000"));
}

TEST_F(DetectTest, ReadsThePosesOfMdlidarEitherWay) {
  MdlidarWriter writer(folder / "town_1", {{0.02, 0.2, 0, 0.03}, {-0.02, 0.1, 0, -0.2}}, 90,
                       Duration::from_nanoseconds(100'000'000));
  for (int k = 0; k < 3; ++k) writer.write(empty_frame(k));
  writer.finish();
  const auto path_with = [&](const std::string& direction) {
    const auto r = run_command(
        {"detect", folder / "town_1", "-o", out(), "--overwrite", "--own-pose-direction", direction});
    EXPECT_EQ(r.exit_code, 4) << r.err;  // no point can be used
    return read_trajectory_file(result().trajectory(), {}).poses().back().T_v0.inverse().translation();
  };
  // The frames say (1, 0, 0) a scan: of the sensor in the world, or of the world in the sensor.
  EXPECT_NEAR(path_with("world_from_sensor").x(), 3, 0.05);
  EXPECT_NEAR(path_with("sensor_from_world").x(), -3, 0.05);
}

TEST_F(DetectTest, TakesNamesThatAreNoUtf8) {
  const std::string latin = folder / "caf\xe9";
  fs::copy(street(), latin, fs::copy_options::recursive);
  const CommandResult r = detect({"--count", "2"}, latin);
  ASSERT_EQ(r.exit_code, 0) << r.err;
  EXPECT_THAT(summary()["recording"].get<std::string>(), testing::EndsWith("caf\xef\xbf\xbd"));
  EXPECT_EQ(run_command({"info", latin, "--json"}).exit_code, 0);
}

TEST_F(DetectTest, NamesTheSensorThatDoesNotFit) {
  expect_error(detect({"--sensor", "HDL-32E"}), 3,
               {"000000.pcd", "HEIGHT = 16", "32 lasers of sensor HDL-32E"});
}

TEST_F(DetectTest, RefusesAnExistingFolderUnlessToldToOverwrite) {
  ASSERT_EQ(detect({"--count", "3"}).exit_code, 0);
  expect_error(detect({"--count", "1"}), 1, {out(), "exists", "--overwrite"});
  EXPECT_EQ(result().labelled_scans().size(), 3u);
  EXPECT_EQ(detect({"--count", "1", "--overwrite"}).exit_code, 0);
  EXPECT_EQ(result().labelled_scans().size(), 1u);
}

TEST_F(DetectTest, NeverOverwritesTheRecordingItself) {
  const std::string copy = street_copy();
  const auto before = files_in(copy);
  expect_error(run_command({"detect", copy, "-o", copy, "--overwrite"}), 1,
               {copy, "neither empty nor the result"});
  EXPECT_EQ(files_in(copy), before);
}

TEST_F(DetectTest, NamesAnOutputThatCannotBeWritten) {
  write_file_atomically(folder / "file", "");
  expect_error(run_command({"detect", street(), "-o", folder / "file" / "out"}), 1, {folder / "file"});
}

TEST_F(DetectTest, NamesAnInputThatIsNotThere) {
  expect_error(detect({}, folder / "nowhere"), 3, {folder / "nowhere"});
  EXPECT_FALSE(fs::exists(out()));
}

TEST_F(DetectTest, EstimatesATrajectoryThatIsThereWhereAskedTo) {
  EXPECT_EQ(detect({"--odometry"}).exit_code, 0);
  EXPECT_EQ(summary()["trajectory"]["source"], "estimated by lidar odometry");
  EXPECT_EQ(summary()["odometry"]["scans"], kScans);
  EXPECT_EQ(summary()["odometry"]["lost"], 0);
  EXPECT_EQ(result().labelled_scans().size(), std::size_t{kScans});
  EXPECT_EQ(detect({"--odometry", "--stationary", "--overwrite"}).exit_code, 2);
}

TEST_F(DetectTest, TellsTheOdometryWhatIsKnownOfTheMotion) {
  const std::string speeds = folder / "speeds.csv";
  write_file_atomically(speeds, "time_s,speed_m_s\n0.75,30\n");  // 8 m/s in truth
  EXPECT_EQ(detect({"--odometry", "--speed", speeds}).exit_code, 4);
  EXPECT_GT(summary()["odometry"]["lost"], 0);
  expect_error(detect({"--speed", speeds, "--overwrite"}), 2, {"--speed", "--odometry"});
}

TEST_F(DetectTest, EstimatesAMissingTrajectory) {
  const std::string copy = street_copy();
  fs::remove(copy + "/trajectory.txt");
  const CommandResult r = detect({}, copy);
  EXPECT_EQ(r.exit_code, 0) << r.err;
  EXPECT_THAT(r.err, HasSubstr("trajectory: estimated by lidar odometry"));
  EXPECT_EQ(summary()["trajectory"]["source"], "estimated by lidar odometry");
  EXPECT_EQ(result().labelled_scans().size(), std::size_t{kScans});
  const auto estimated = read_trajectory_file(result().trajectory(), {});
  const auto truth = test::toy_street().trajectory;
  const SE3 T_first = truth->at(estimated.poses().front().time).T_v0;
  for (const TimedPose& pose : estimated.poses()) {
    const SE3 T_true = truth->at(pose.time).T_v0 * T_first.inverse();
    EXPECT_LT((pose.T_v0 * T_true.inverse()).log().head<3>().norm(), 0.1);
  }
}

TEST_F(DetectTest, NamesFewerPosesThanScans) {
  expect_error(detect({"--trajectory", pose_rows(kScans - 1)}), 3, {"poses.txt"});
  EXPECT_FALSE(fs::exists(out()));
  EXPECT_EQ(detect({"--trajectory", pose_rows(kScans), "--pose-instant", "start"}).exit_code, 0);
  EXPECT_EQ(summary()["trajectory"]["times"], "start of each scan");
}

TEST_F(DetectTest, NamesTheScanATrajectoryDoesNotReachBeforeAnyWork) {
  write_file_atomically(folder / "tum.txt", "0 0 0 0 0 0 0 1\n0.75 6 0 0 0 0 0 1\n");
  expect_error(detect({"--trajectory", folder / "tum.txt"}), 3, {"000007.pcd", "scan 7", "0.75", "--count"});
  EXPECT_FALSE(fs::exists(out()));
  EXPECT_EQ(detect({"--trajectory", folder / "tum.txt", "--count", "7"}).exit_code, 0);
}

TEST_F(DetectTest, ABrokenScanLeavesTheFinishedOnesAndSaysSo) {
  const std::string copy = street_copy();
  fs::resize_file(copy + "/scans/000005.pcd", fs::file_size(copy + "/scans/000005.pcd") / 2);
  expect_error(detect({"--causal"}, copy), 3, {"000005.pcd"});
  EXPECT_EQ(result().labelled_scans(), (std::vector<std::size_t>{0, 1, 2, 3, 4}));
  EXPECT_EQ(summary()["complete"], false);
  EXPECT_THAT(summary()["stopped"].get<std::string>(), HasSubstr("000005.pcd"));
}

TEST_F(DetectTest, ABrokenFirstScanLeavesNothingAndAnEarlierResultAsItWas) {
  const std::string copy = street_copy();
  fs::resize_file(copy + "/scans/000000.pcd", fs::file_size(copy + "/scans/000000.pcd") / 2);
  expect_error(detect({}, copy), 3, {"000000.pcd"});
  EXPECT_FALSE(fs::exists(out()));
  ASSERT_EQ(detect({"--count", "2"}).exit_code, 0);
  const auto files = files_in(out());
  const std::string before = read_whole_file(result().summary());
  expect_error(detect({"--overwrite"}, copy), 3, {"000000.pcd"});
  EXPECT_EQ(files_in(out()), files);
  EXPECT_EQ(read_whole_file(result().summary()), before);
}

// The scans are enough that the signal, sent at the first sign of progress, comes long before the last.
TEST_F(DetectTest, AnInterruptFinishesTheScanInHand) {
  test::write_toy_sequence(test::toy_street("VLP-16"), 30, folder / "long");
  test::RunningCommand command({"detect", folder / "long", "-o", out()});
  ASSERT_TRUE(command.wait_for_error_line("1 of 30 scans"));
  command.send(SIGINT);
  const CommandResult r = command.wait();
  EXPECT_EQ(r.exit_code, 130);
  EXPECT_THAT(r.err, HasSubstr("interrupted"));
  const auto s = summary();
  EXPECT_EQ(s["complete"], false);
  const auto finished = result().labelled_scans();
  EXPECT_EQ(s["scans"], finished.size());
  EXPECT_LT(finished.size(), 30u);
  const auto dataset = open_dataset(folder / "long");
  for (const std::size_t k : finished)
    EXPECT_NO_THROW((void)read_label_file(result().label_file(k), 16u * dataset->model()->columns));
  for (const fs::path& file : files_in(out())) {
    EXPECT_TRUE(file.extension() == ".label" || file.extension() == ".stages" ||
                file.has_parent_path() == false)
        << file;
  }
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
