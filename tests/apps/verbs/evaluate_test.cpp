#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

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
using testing::Not;

/// Three simulated scans, and their truth for a result, as the result of one object a scan.
void make_recording_and_result(const std::string& format, const fs::path& recording, const fs::path& result) {
  const CommandResult made = run_command({"simulate", "crossing", "-o", recording.string(), "--sensor",
                                          "VLP-16", "--duration-s", "0.3", "--format", format});
  ASSERT_EQ(made.exit_code, 0) << made.err;
  const ResultFolder folder(result);
  fs::create_directories(folder.labels());
  DatasetOptions reading;
  reading.format = format;
  const auto dataset = open_dataset(recording, reading);
  for (std::size_t k = 0; k < dataset->size(); ++k) {
    std::vector<std::uint32_t> labels = dataset->read_labels(k).value();
    for (std::uint32_t& label : labels) {
      label &= 0xFFFFu;
      if (motion_of_label(label) == MotionTruth::moving) label |= 1u << 16;
    }
    write_label_file(folder.label_file(k), labels);
  }
}

class EvaluateSimulated : public testing::TestWithParam<const char*> {};

TEST_P(EvaluateSimulated, TheTruthItselfIsRightByEveryMeasure) {
  const test::TemporaryFolder folder;
  const std::string recording = (folder / "recording");
  const std::string result = (folder / "result");
  make_recording_and_result(GetParam(), recording, result);
  const std::string json = folder / "e.json";
  const CommandResult r =
      run_command({"evaluate", recording, result, "--format", GetParam(), "--json", json});
  ASSERT_EQ(r.exit_code, 0) << r.err;
  for (const char* table : {"final labels", "range [m]", "class", "true speed [m/s]", "visible points",
                            "objects found", "evident movers", "false objects"}) {
    EXPECT_THAT(r.out, HasSubstr(table));
  }
  const auto report = nlohmann::json::parse(read_whole_file(json))["report"];
  EXPECT_EQ(report["points"]["scans"], 3);
  const std::int64_t moving = report["points"]["tp"];
  EXPECT_GT(moving, 0);
  EXPECT_EQ(report["points"]["iou"], 1.0);
  EXPECT_EQ(report["objects"]["share"], 1.0);
  EXPECT_GT(report["evident_movers"]["of"], 0);
  EXPECT_EQ(report["false_objects"]["objects"], 3);
  EXPECT_EQ(report["false_objects"]["per_scan"], 0.0);
  // Every dynamic point is of one mover, which has a state and a class.
  for (const char* split : {"by_speed", "by_visible_points"}) {
    std::int64_t sum = 0;
    for (const auto& band : report[split]) sum += band["of"].get<std::int64_t>();
    EXPECT_EQ(sum, moving) << split;
  }
  std::int64_t of_movers = 0;
  for (const auto& kind : report["by_kind"]) {
    EXPECT_NE(kind["class"], "(unlisted)");
    if (kind["kind"] == "mover") of_movers += kind["tp"].get<std::int64_t>();
  }
  EXPECT_EQ(of_movers, moving);
}

INSTANTIATE_TEST_SUITE_P(Formats, EvaluateSimulated, testing::Values("native", "mdlidar", "kitti"));

TEST(Evaluate, PrintsWhatTheTruthAllows) {
  const test::TemporaryFolder folder;
  const std::string recording = folder / "recording";
  const std::string result = folder / "result";
  make_recording_and_result("native", recording, result);
  // Labels from elsewhere do not number the objects as the recording's tables do.
  fs::create_directories(fs::path(folder / "elsewhere"));
  fs::rename(recording + "/labels", folder / "elsewhere/labels");
  const std::vector<std::string> command = {"evaluate", recording, result, "--labels",
                                            folder / "elsewhere/labels"};
  const CommandResult without = run_command(command);
  ASSERT_EQ(without.exit_code, 0) << without.err;
  EXPECT_THAT(without.out, HasSubstr("range [m]"));
  EXPECT_THAT(without.out, HasSubstr("objects found"));
  EXPECT_THAT(without.out, Not(HasSubstr("true speed")));
  EXPECT_THAT(without.out, Not(HasSubstr("evident")));
  fs::copy_file(recording + "/objects.csv", folder / "elsewhere/objects.csv");
  const CommandResult with_classes = run_command(command);
  EXPECT_THAT(with_classes.out, HasSubstr("class"));
  EXPECT_THAT(with_classes.out, Not(HasSubstr("true speed")));
  std::ofstream(folder / "elsewhere/object_states.csv") << "scan,id\n";
  const CommandResult broken = run_command(command);
  EXPECT_EQ(broken.exit_code, 3);
  EXPECT_THAT(broken.err, HasSubstr("object_states.csv:1"));
}

// Eight scans with a true trajectory and no labels, and the same drive one percent too long.
class EvaluateTrajectory : public testing::Test {
 protected:
  EvaluateTrajectory() {
    test::write_toy_sequence(test::toy_street("VLP-16"), 8, recording);
    fs::remove_all(recording + "/labels");
    fs::create_directories(result);
    auto poses = read_trajectory_file(recording + "/trajectory.txt", {}).poses();
    for (TimedPose& pose : poses) {
      const SE3 T_0v = pose.T_v0.inverse();
      pose.T_v0 = SE3(T_0v.rotation(), 1.01 * T_0v.translation()).inverse();
    }
    write_tum_trajectory(result + "/trajectory.txt", poses);
    poses.pop_back();  // the end of the last scan
    write_kitti_poses(result + "/poses_kitti.txt", poses);
  }

  [[nodiscard]] nlohmann::json figures(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), {"evaluate", recording});
    arguments.insert(arguments.end(), {"--json", "-"});
    const CommandResult r = run_command(arguments);
    EXPECT_EQ(r.exit_code, 0) << r.err;
    return nlohmann::json::parse(r.out, nullptr, false);
  }

  test::TemporaryFolder folder;
  std::string recording = folder / "recording", result = folder / "result";
};

TEST_F(EvaluateTrajectory, OfAFolderOrAFile) {
  for (const char* file : {"", "/trajectory.txt", "/poses_kitti.txt"}) {
    SCOPED_TRACE(file);
    const auto of = figures({result + file});
    EXPECT_FALSE(of.contains("final")) << "no labels";
    // 8 m/s: 0.8 m a scan, of which one percent.
    EXPECT_NEAR(of["trajectory"]["relative_per_scan"]["translation_m"]["rmse"], 0.008, 1e-4);
    EXPECT_NEAR(of["trajectory"]["relative_per_scan"]["rotation_deg"]["max"], 0, 1e-4);
    EXPECT_NEAR(of["trajectory"]["path_length_m"], 5.6, 0.01);
    EXPECT_EQ(of["trajectory"]["poses"], 8);
  }
  const CommandResult printed = run_command({"evaluate", recording, result});
  ASSERT_EQ(printed.exit_code, 0) << printed.err;
  for (const char* row : {"drift over [m]", "absolute, aligned as a whole", "relative, per scan", "velocity",
                          "static points, 4 scans apart"}) {
    EXPECT_THAT(printed.out, HasSubstr(row));
  }
}

TEST_F(EvaluateTrajectory, AgainstAGivenTruth) {
  const auto of = figures(
      {result, "--reference-trajectory", result + "/poses_kitti.txt", "--reference-pose-instant", "start"});
  EXPECT_NEAR(of["trajectory"]["absolute_from_first"]["translation_m"]["max"], 0, 1e-9);
  fs::remove(recording + "/trajectory.txt");
  const CommandResult r = run_command({"evaluate", recording, result + "/trajectory.txt"});
  EXPECT_EQ(r.exit_code, 3);
  EXPECT_THAT(r.err, HasSubstr("--reference-trajectory"));
  fs::create_directories(result + "/labels");
  EXPECT_EQ(run_command({"evaluate", recording, result}).exit_code, 3) << "neither labels nor a truth";
}

// A run that was given the recording's own trajectory has no error of its own to evaluate.
TEST_F(EvaluateTrajectory, NotAgainstItself) {
  write_file_atomically(result + "/summary.json", R"({"trajectory": {"source": "recording"}})");
  EXPECT_EQ(run_command({"evaluate", recording, result}).exit_code, 3);
  write_file_atomically(result + "/summary.json", R"({"trajectory": {"source": "estimated"}})");
  EXPECT_EQ(run_command({"evaluate", recording, result}).exit_code, 0);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
