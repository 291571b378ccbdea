#include <cstring>
#include <filesystem>
#include <map>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/command.hpp"
#include "support/temporary_folder.hpp"
#include "support/toy_sequence.hpp"
#include <mapless/io/dataset.hpp>
#include <mapless/io/files.hpp>
#include <mapless/io/labels.hpp>
#include <mapless/io/result_folder.hpp>

namespace mapless {
namespace MAPLESS_FILE {

using test::run_command;
using testing::HasSubstr;

constexpr int kScans = 3;

struct Record {
  float x, y, z;
  std::uint32_t label, object, record;
};

/// The exported points of a scan with all their fields.
std::vector<Record> read_labelled(const std::filesystem::path& file) {
  const std::string bytes = read_whole_file(file), last = "DATA binary\n";
  const std::size_t data = bytes.find(last) + last.size();
  std::vector<Record> out((bytes.size() - data) / sizeof(Record));
  std::memcpy(out.data(), bytes.data() + data, bytes.size() - data);
  return out;
}

std::size_t records_in(const std::filesystem::path& file, const std::string& last_line, std::size_t size) {
  const std::string bytes = read_whole_file(file);
  return (bytes.size() - bytes.find(last_line) - last_line.size()) / size;
}

class Export : public testing::Test {
 protected:
  Export() { test::write_toy_sequence(test::toy_street("VLP-16"), kScans, street); }

  test::TemporaryFolder folder;
  std::string street = folder / "street", out = folder / "out";
};

TEST_F(Export, LabelledPointsLieWhereTheirRaysHitAndKeepTheirLabels) {
  ASSERT_EQ(run_command({"export", street, "--what", "labelled", "-o", out}).exit_code, 0);
  const auto dataset = open_dataset(street);
  const auto trajectory = dataset->trajectory();
  for (std::size_t k = 0; k < kScans; ++k) {
    const LidarScan scan = dataset->read(k);
    const std::vector<std::uint32_t> truth = dataset->read_labels(k).value();
    std::map<std::uint32_t, Eigen::Vector3d> place_of;
    for (const LidarReturn& r : scan.returns) {
      place_of[r.input_index] = trajectory->at(scan.time_of(r)).T_v0.inverse() * r.position_v.cast<double>();
    }
    const std::vector<Record> records =
        read_labelled(std::filesystem::path(out) / fmt::format("{:06}.pcd", k));
    ASSERT_EQ(records.size(), scan.returns.size());
    for (const Record& r : records) {
      EXPECT_LT((Eigen::Vector3d(r.x, r.y, r.z) - place_of.at(r.record)).norm(), 1e-3);
      EXPECT_EQ(r.label == kLabelDynamic, motion_of_label(truth[r.record]) == MotionTruth::moving);
    }
  }
}

TEST_F(Export, EveryPointIsStaticOrMovingOrHasNoLabel) {
  std::size_t is_static = 0, moving = 0, returns = 0;
  const auto dataset = open_dataset(street);
  const std::vector<std::uint32_t> truth = dataset->read_labels(1).value();
  for (const LidarReturn& r : dataset->read(1).returns) {
    ++returns;
    is_static += motion_of_label(truth[r.input_index]) == MotionTruth::still;
    moving += motion_of_label(truth[r.input_index]) == MotionTruth::moving;
  }
  ASSERT_GT(moving, 0U);
  const auto points_of = [&](const std::string& what) {
    const std::string to = folder / what;
    const auto r = run_command({"export", street, "--what", what, "-o", to, "--scans", "1:1",
                                "--cloud-format", "ply", "--frame", "sensor"});
    EXPECT_EQ(r.exit_code, 0) << r.err;
    return records_in(std::filesystem::path(to) / "000001.ply", "end_header\n", 12);
  };
  EXPECT_EQ(points_of("static"), is_static);
  EXPECT_EQ(points_of("moving"), moving);
  EXPECT_LE(is_static + moving, returns);
}

TEST_F(Export, TheMapCountsWhatItKeepsAndWhatItRemoves) {
  std::size_t is_static = 0, moving = 0;
  const auto dataset = open_dataset(street);
  for (std::size_t k = 0; k < kScans; ++k) {
    const std::vector<std::uint32_t> truth = dataset->read_labels(k).value();
    for (const LidarReturn& r : dataset->read(k).returns) {
      is_static += motion_of_label(truth[r.input_index]) == MotionTruth::still;
      moving += motion_of_label(truth[r.input_index]) == MotionTruth::moving;
    }
  }
  const auto made = run_command({"export", street, "--what", "map", "-o", out + ".pcd", "--voxel-m", "0.5"});
  ASSERT_EQ(made.exit_code, 0) << made.err;
  EXPECT_THAT(made.out,
              HasSubstr(fmt::format("{} points static and kept, {} dynamic and removed", is_static, moving)));
  const std::string bytes = read_whole_file(out + ".pcd");
  std::size_t counted = 0;
  for (std::size_t at = bytes.find("DATA binary\n") + 12; at < bytes.size(); at += 16) {
    std::uint32_t points = 0;
    std::memcpy(&points, bytes.data() + at + 12, sizeof points);
    counted += points;
  }
  EXPECT_EQ(counted, is_static);
}

TEST_F(Export, RefusesAFolderThatHasFilesAndAMapInTheFrameOfTheSensor) {
  EXPECT_THAT(run_command({"export", street, "--what", "static", "-o", street}).err,
              HasSubstr("not an empty folder"));
  const auto map = run_command({"export", street, "--what", "map", "-o", out, "--frame", "sensor"});
  EXPECT_NE(map.exit_code, 0);
  EXPECT_THAT(map.err, HasSubstr("--frame"));
  EXPECT_FALSE(std::filesystem::exists(out));
}

TEST_F(Export, PredictionsOfSemanticKittiHaveOneLabelPerRecord) {
  const std::filesystem::path result = folder / "result";
  const auto dataset = open_dataset(street);
  const std::size_t records = dataset->read(1).input_size;
  std::vector<std::uint32_t> labels(records, kLabelStatic);
  labels[3] = 7u << 16 | kLabelDynamic;
  labels[4] = kLabelUnknown;
  std::filesystem::create_directories(result / "labels");
  write_label_file(result / "labels" / "000001.label", labels);
  const auto r = run_command(
      {"export", street, result.string(), "--what", "semantic-kitti", "--sequence", "08", "-o", out});
  ASSERT_EQ(r.exit_code, 0) << r.err;
  std::vector<std::uint32_t> expected(records, kLabelStatic);
  expected[3] = kLabelDynamic;
  const auto predictions = std::filesystem::path(out) / "sequences" / "08" / "predictions";
  EXPECT_EQ(read_label_file(predictions / "000001.label", records), expected);
  EXPECT_THAT(r.out, HasSubstr("1 files; 1 points moving"));
  EXPECT_THAT(run_command({"export", street, result.string(), "--what", "semantic-kitti", "--sequence", "08",
                           "-o", out})
                  .err,
              HasSubstr("not an empty folder"));
  EXPECT_THAT(run_command({"export", street, "--what", "semantic-kitti", "-o", out}).err, HasSubstr("OUT"));
}

// The records of a result by mapless detect with a label are those with a return.
TEST_F(Export, RefusesLabelsOfAnotherRecording) {
  const ResultFolder result(folder / "result");
  result.create(false, "{}");
  const LidarScan scan = open_dataset(street)->read(0);
  ASSERT_LT(scan.returns.size(), scan.input_size * 98 / 100);
  write_label_file(result.label_file(0), std::vector<std::uint32_t>(scan.input_size, kLabelStatic));
  for (const std::string what : {"labelled", "map", "semantic-kitti"}) {
    const auto r = run_command({"export", street, result.path().string(), "--what", what, "-o", out});
    EXPECT_EQ(r.exit_code, 3) << what;
    EXPECT_THAT(r.err, HasSubstr("000000.label: labels = ")) << what;
    std::filesystem::remove_all(out);
  }
  for (const auto& command : {std::vector<std::string>{"view"}, {"render", "--scan", "0"}}) {
    std::vector<std::string> arguments = command;
    for (const std::string& more : {street, result.path().string(), std::string("-o"), out})
      arguments.push_back(more);
    EXPECT_EQ(run_command(arguments).exit_code, 3) << command[0];
    EXPECT_FALSE(std::filesystem::exists(out)) << command[0];
  }
}

TEST_F(Export, ThatFailsLeavesNothing) {
  const ResultFolder result(folder / "result");
  result.create(false, "{}");
  const auto dataset = open_dataset(street);
  for (std::size_t k = 0; k < kScans; ++k) write_label_file(result.label_file(k), *dataset->read_labels(k));
  write_file_atomically(result.label_file(kScans - 1), "damaged");
  const std::filesystem::path deep = std::filesystem::path(out) / "a/b";
  for (const std::string what : {"static", "semantic-kitti"}) {
    const std::vector<std::string> command = {"export", street, result.path().string(), "--what", what, "-o"};
    const auto into = [&command](std::string output) {
      std::vector<std::string> all = command;
      all.push_back(std::move(output));
      return run_command(all).exit_code;
    };
    EXPECT_EQ(into(deep), 3) << what;
    EXPECT_FALSE(std::filesystem::exists(out)) << what;
    std::filesystem::create_directories(deep);
    EXPECT_EQ(into(deep), 3) << what;
    EXPECT_TRUE(std::filesystem::is_empty(deep)) << what << ": was there before, and stays";
    std::filesystem::remove_all(out);
  }
}

TEST_F(Export, ASequenceIsAWholeNumber) {
  for (const std::string sequence : {"../../x", "3.5", "-1", ""}) {
    const auto r = run_command({"export", street, folder / "result", "--what", "semantic-kitti", "-o", out,
                                "--sequence=" + sequence});
    EXPECT_EQ(r.exit_code, 2) << sequence;
  }
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
