#include <filesystem>
#include <memory>
#include <numbers>
#include <string>

#include <gtest/gtest.h>

#include "support/memory_dataset.hpp"
#include "support/temporary_folder.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/evaluation/evaluator.hpp>
#include <mapless/io/files.hpp>
#include <mapless/io/labels.hpp>
#include <mapless/io/trajectory_file.hpp>

namespace mapless {
namespace MAPLESS_FILE {

using test::MemoryDataset;
using test::regular_starts;

constexpr std::uint32_t kMoving = 252, kStill = 9;

class ResultEvaluationTest : public testing::Test {
 protected:
  ResultEvaluationTest() : dataset(regular_starts(3), 4), result(folder / "out") {
    std::filesystem::create_directories(result.labels());
    std::filesystem::create_directories(result.stages());
  }

  // Records 1, 2, 3, 4 m away: moving, moving, still, unknown.
  void add_scan(std::size_t k) {
    dataset.labels[k] = {kMoving, kMoving, kStill, 0};
    write_label_file(result.label_file(k),
                     {kLabelDynamic | 1u << 16, kLabelStatic, kLabelStatic, kLabelDynamic});
  }

  test::TemporaryFolder folder;
  MemoryDataset dataset;
  ResultFolder result;
  EvaluationOptions options{.stages = 5, .max_range_m = {}, .objects = {}, .progress = {}};
};

TEST_F(ResultEvaluationTest, CountsOnlyScansWithTruthAndResult) {
  add_scan(0);
  add_scan(2);
  dataset.labels[1] = {kStill, kStill, kStill, kStill};  // no result
  dataset.labels.erase(2);                               // no truth
  const ResultEvaluation e = evaluate_result(dataset, result, options);
  EXPECT_EQ(e.labelled_scans, 2u);
  EXPECT_EQ(e.scans_without_truth, 1u);
  EXPECT_EQ(e.scans, std::vector<std::size_t>{0});
  EXPECT_EQ(e.report.points.total(), (Counts{.tp = 1, .fp = 0, .fn = 1, .tn = 1}));
}

TEST_F(ResultEvaluationTest, ReadsEachStageFromItsBit) {
  add_scan(0);
  add_scan(1);
  // After comparison all four are dynamic, after backward the first and the third, after forward none, then
  // the first.
  write_stage_file(result.stage_file(1), {0b11011, 0b00001, 0b00011, 0b00001});
  const ResultEvaluation e = evaluate_result(dataset, result, options);
  EXPECT_EQ(e.report.points.scans(), 2);
  ASSERT_EQ(e.after_stage.size(), 5u);
  EXPECT_EQ(e.after_stage[0].scans(), 1) << "scan 0 has no stage file";
  EXPECT_EQ(e.after_stage[0].total(), (Counts{.tp = 2, .fp = 1, .fn = 0, .tn = 0}));
  EXPECT_EQ(e.after_stage[1].total(), (Counts{.tp = 1, .fp = 1, .fn = 1, .tn = 0}));
  EXPECT_EQ(e.after_stage[2].total(), (Counts{.tp = 0, .fp = 0, .fn = 2, .tn = 1}));
  EXPECT_EQ(e.after_stage[4].total(), (Counts{.tp = 1, .fp = 0, .fn = 1, .tn = 1}));
}

TEST_F(ResultEvaluationTest, LeavesOutPointsBeyondTheRange) {
  add_scan(0);
  options.max_range_m = 1.5;
  EXPECT_EQ(evaluate_result(dataset, result, options).report.points.total(),
            (Counts{.tp = 1, .fp = 0, .fn = 0, .tn = 0}));
  options.max_range_m = 2.0;
  EXPECT_EQ(evaluate_result(dataset, result, options).report.points.total(),
            (Counts{.tp = 1, .fp = 0, .fn = 1, .tn = 0}));
}

TEST_F(ResultEvaluationTest, TakesClassesAndSpeedsFromTheTables) {
  add_scan(1);
  dataset.labels[1] = {kMoving | 5u << 16, kMoving | 5u << 16, kStill, 0};
  options.objects = folder / "tables";
  std::filesystem::create_directories(options.objects);
  EXPECT_TRUE(evaluate_result(dataset, result, options).report.by_class.empty());
  write_file_atomically(options.objects / "objects.csv", "object_id,class,kind\n5,dog,mover\n");
  ObjectStatesWriter states(options.objects / "object_states.csv");
  ObjectState state{Time::from_seconds(0.15), {0, 0, 0}, {0, 3, 0}, 3};
  states.add(1, {{5, state}});
  const EvaluationReport report = evaluate_result(dataset, result, options).report;
  ASSERT_EQ(report.by_class.size(), 2u);
  EXPECT_EQ(report.by_class[1].object_class, "dog");
  EXPECT_EQ(report.by_class[1].points, (Counts{.tp = 1, .fn = 1}));
  EXPECT_EQ(report.by_class[1].objects, (Found{1, 1}));
  EXPECT_EQ(report.by_speed[4].counts, (Found{1, 2})) << "between 2 and 5 m/s";
  EXPECT_EQ(report.by_range[0].counts, (Counts{.tp = 1, .fn = 1, .tn = 1}));
  // A scan taken out of the recording would shift the rest.
  state.time = Time::from_seconds(0.25);
  states.add(0, {{5, state}});
  EXPECT_THROW((void)evaluate_result(dataset, result, options), InputError);
}

// Scan 1: object 5 moves with 3 m/s along y. The result's world is turned by 90 degrees against the true one.
class ResultVelocityTest : public ResultEvaluationTest {
 protected:
  ResultVelocityTest() {
    add_scan(1);
    dataset.labels[1] = {kMoving | 5u << 16, kMoving | 5u << 16, kStill, 0};
    options.objects = folder / "tables";
    std::filesystem::create_directories(options.objects);
    ObjectStatesWriter(options.objects / "object_states.csv")
        .add(1, {{5, {Time::from_seconds(0.15), {0, 0, 0}, {0, 3, 0}, 3}}});
    write_file_atomically(result.summary(), "{}");
  }
  void write_rows(std::uint32_t id, const Eigen::Vector3d& velocity) const {
    ObjectRow row{1, Time::from_seconds(0.15), id, 2, {0, 0, 0}, {1, 1, 1}, velocity, {0.5, 0.5, 0.5}, 2};
    ObjectTableWriter(result.objects()).add({row});
  }
  [[nodiscard]] std::string message() const {
    try {
      (void)evaluate_result(dataset, result, options);
    } catch (const InputError& error) {
      return error.what();
    }
    return "no error";
  }
};

TEST_F(ResultVelocityTest, EvaluatesTheVelocityInTheWorldOfTheResult) {
  write_rows(1, {0, 3, 0});
  const auto same_world = evaluate_result(dataset, result, options).velocity;
  ASSERT_TRUE(same_world);
  EXPECT_EQ(same_world->evaluated, 1);
  EXPECT_NEAR(same_world->rms_mps.value(), 0, 1e-9);
  // The sensor lies along the true axes, and turned by -90 degrees about z in the result's world.
  dataset.own_trajectory = std::make_shared<StationaryTrajectory>();
  const SE3 T_v0(rotation_z(-std::numbers::pi / 2).transpose(), {1, 2, 3});
  write_tum_trajectory(result.trajectory(), {{Time::from_seconds(0), T_v0}, {Time::from_seconds(1), T_v0}});
  write_rows(1, {3, 0, 0});
  EXPECT_NEAR(evaluate_result(dataset, result, options).velocity->rms_mps.value(), 0, 1e-6);
}

TEST_F(ResultVelocityTest, IsAbsentWithoutTruthAndForFoldersOfLabelsOnly) {
  write_rows(1, {0, 3, 0});
  std::filesystem::remove(result.summary());
  EXPECT_FALSE(evaluate_result(dataset, result, options).velocity);
  write_file_atomically(result.summary(), "{}");
  options.objects.clear();
  EXPECT_FALSE(evaluate_result(dataset, result, options).velocity);
}

TEST_F(ResultVelocityTest, NamesATableThatIsMissingInvalidOrOfAnotherRun) {
  EXPECT_NE(message().find("objects.csv"), std::string::npos) << message();
  write_file_atomically(result.objects(), "object_id,class,kind\n");
  EXPECT_NE(message().find("objects.csv:1: head"), std::string::npos) << message();
  write_rows(2, {0, 3, 0});  // the labels have object 1
  EXPECT_NE(message().find("scan 1, object 1 of its labels"), std::string::npos) << message();
  EXPECT_EQ(message().find('\n'), std::string::npos);
}

TEST_F(ResultEvaluationTest, RefusesResultsOfAnotherRecording) {
  add_scan(0);
  write_label_file(result.label_file(7), {kLabelStatic});
  EXPECT_THROW((void)evaluate_result(dataset, result, options), InputError);
}

TEST_F(ResultEvaluationTest, RefusesFilesOfAnotherLength) {
  add_scan(0);
  write_stage_file(result.stage_file(0), {0, 0, 0});
  EXPECT_THROW((void)evaluate_result(dataset, result, options), InputError);
  std::filesystem::remove(result.stage_file(0));
  write_label_file(result.label_file(0), {kLabelStatic});
  EXPECT_THROW((void)evaluate_result(dataset, result, options), InputError);
}

TEST_F(ResultEvaluationTest, RefusesAResultWithoutAnyTrueLabels) {
  EXPECT_THROW((void)evaluate_result(dataset, result, options), InputError);
  EXPECT_THROW((void)evaluate_result(dataset, ResultFolder(folder / "nowhere"), options), InputError);
}

// 1000 records, the last 200 of them without a return.
class LabelAlignmentTest : public testing::Test {
 protected:
  LabelAlignmentTest() : dataset(regular_starts(1), 1000), result(folder / "out") {
    dataset.missing[0] = 200;
    dataset.labels[0] = labels(0, 800, 100, 300);
    std::filesystem::create_directories(result.labels());
    write_file_atomically(result.summary(), "{}");
  }
  // Labels of records with a return from `begin` to `end`, those from `moving` to `still` moving.
  static std::vector<std::uint32_t> labels(std::size_t begin, std::size_t end, std::size_t moving,
                                           std::size_t still) {
    std::vector<std::uint32_t> out(1000, kLabelUnknown);
    for (std::size_t i = begin; i < end; ++i)
      out[i] = i >= moving && i < still ? kLabelDynamic : kLabelStatic;
    return out;
  }
  [[nodiscard]] std::string refusal(const std::vector<std::uint32_t>& of_result) const {
    write_label_file(result.label_file(0), of_result);
    try {
      (void)evaluate_result(dataset, result, {});
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }

  test::TemporaryFolder folder;
  MemoryDataset dataset;
  ResultFolder result;
};

TEST_F(LabelAlignmentTest, AResultOfTheseScansIsEvaluated) {
  EXPECT_EQ(refusal(labels(0, 800, 0, 50)), "");
  EXPECT_EQ(refusal(labels(0, 0, 0, 0)), "");  // the motion was lost
}

TEST_F(LabelAlignmentTest, AResultOfOtherScansIsRefused) {
  EXPECT_NE(refusal(labels(50, 850, 0, 50)).find("labels = 100 of 1000"), std::string::npos);
  std::filesystem::remove(result.summary());  // of another program, which may label what it likes
  EXPECT_EQ(refusal(labels(50, 850, 0, 50)), "");
}

TEST_F(LabelAlignmentTest, TrueLabelsOfOtherScansAreRefused) {
  dataset.labels[0] = labels(100, 900, 700, 900);
  EXPECT_NE(refusal(labels(0, 800, 0, 50)).find("moving points = 100 of 200"), std::string::npos);
  dataset.labels[0] = labels(100, 900, 610, 810);  // 10 of 200: another account of what is faulty
  EXPECT_EQ(refusal(labels(0, 800, 0, 50)), "");
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
