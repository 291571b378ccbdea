#include "run/detection_run.hpp"

#include <algorithm>
#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "run/given_motion.hpp"
#include "support/temporary_folder.hpp"
#include "support/toy_sequence.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/dataset.hpp>
#include <mapless/io/files.hpp>

namespace mapless::app {
namespace MAPLESS_FILE {

namespace fs = std::filesystem;
using testing::HasSubstr;

constexpr std::size_t kScans = 10;

class DetectionRunThreads : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    shared = new test::TemporaryFolder;  // NOLINT: lives as long as the suite
    test::write_toy_sequence(with_columns(test::toy_street("VLP-16"), 600), kScans, *shared / "street");
  }
  static void TearDownTestSuite() { delete shared; }  // NOLINT

  struct Setting {
    bool odometry = false;
    bool side_by_side = true;
    std::optional<RealTimePace> pace;
    std::function<void(const ResultFolder&)> after_making = [](const ResultFolder&) {};
  };
  // What `mapless detect` does, and the text of its summary.
  static std::string run(const fs::path& output, Setting setting) {
    const auto dataset = open_dataset(*shared / "street");
    const TrajectorySource motion =
        setting.odometry ? motion_by_odometry(*dataset, 0) : given_motion(*dataset, {}, 0);
    const ResultFolder result(output);
    RunSummary summary(*dataset, "street", motion, "default", 0, kScans);
    const auto make_folder = [&] {
      result.create(false, summary.text());
      setting.after_making(result);
    };
    OnlineDetectorOptions options;
    options.side_by_side = setting.side_by_side;
    DetectionRun detection(*dataset, motion.trajectory, result, options, summary, {0, kScans},
                           std::move(setting.pace), make_folder);
    try {
      EXPECT_TRUE(detection.run());
      summary.set_complete();
    } catch (const std::exception& error) {
      summary.set_stopped(error.what());
    }
    detection.write_outcome();
    return summary.text();
  }
  static std::vector<fs::path> files_in(const fs::path& root) {
    std::vector<fs::path> files;
    for (const auto& entry : fs::recursive_directory_iterator(root)) {
      if (entry.is_regular_file() && entry.path().filename() != "summary.json")  // has times
        files.push_back(fs::relative(entry.path(), root));
    }
    std::sort(files.begin(), files.end());
    return files;
  }

  static inline test::TemporaryFolder* shared = nullptr;
  test::TemporaryFolder folder;
};

TEST_F(DetectionRunThreads, OdometryBesideDetectionGivesTheSameBytes) {
  run(folder / "beside", {true, true, {}});
  run(folder / "alone", {true, false, {}});
  const auto files = files_in(folder / "beside");
  EXPECT_EQ(files, files_in(folder / "alone"));
  EXPECT_EQ(files.size(), 2 * kScans + 4);  // labels, stages; objects and poses
  for (const fs::path& file : files) {
    EXPECT_EQ(read_whole_file(fs::path(folder / "beside") / file),
              read_whole_file(fs::path(folder / "alone") / file))
        << file;
  }
}

TEST_F(DetectionRunThreads, WhatCannotBeWrittenEndsTheRunAndLeavesTheScansBefore) {
  const auto block = [](const ResultFolder& result) { fs::create_directory(result.label_file(3)); };
  const std::string summary = run(folder / "out", {false, true, {}, block});
  const ResultFolder result(folder / "out");
  fs::remove(result.label_file(3));
  EXPECT_EQ(result.labelled_scans(), (std::vector<std::size_t>{0, 1, 2}));
  EXPECT_THAT(summary, HasSubstr("\"complete\": false"));
  EXPECT_THAT(summary, HasSubstr("000003.label: cannot be written: it is a folder"));
  EXPECT_THAT(summary, HasSubstr("\"scans\": 3,"));
  const std::string poses = read_whole_file(result.kitti_poses());
  EXPECT_EQ(std::count(poses.begin(), poses.end(), '\n'), 3);
}

// Every look at the clock takes 400 ms, four scans: more come than the queue holds.
TEST_F(DetectionRunThreads, ScansThatAreDroppedHaveNoLabels) {
  const auto dataset = open_dataset(*shared / "street");
  std::vector<Time> ends;
  for (std::size_t k = 0; k < kScans; ++k) ends.push_back(dataset->scan_end(k));
  Time now;
  const Clock clock{[&now] { return now = now + Duration::from_seconds(0.4); },
                    [](Time) { ADD_FAILURE() << "there is always a scan"; }};
  const auto json = nlohmann::json::parse(
      run(folder / "out", {false, true, RealTimePace(dataset->scan_start(0), ends, clock)}));
  const ResultFolder result(folder / "out");
  const auto labelled = result.labelled_scans();
  // Each look at the clock takes 0.4 s: one before each scan is taken, one after it is labelled. So the first
  // scan is taken 0.4 s after the start, and the second at 1.2 s, when all ten have arrived and the oldest
  // of more than RealTimePace::kQueue waiting scans are dropped.
  EXPECT_EQ(labelled, (std::vector<std::size_t>{0, 5, 6, 7, 8, 9}));
  EXPECT_EQ(json["scans"], labelled.size());
  EXPECT_EQ(json["real_time"]["dropped"], kScans - labelled.size());
  EXPECT_EQ(json["real_time"]["scans"], kScans);
  EXPECT_GE(json["real_time"]["latency"]["median_ms"], 0);
  const std::string poses = read_whole_file(result.kitti_poses());
  EXPECT_EQ(static_cast<std::size_t>(std::count(poses.begin(), poses.end(), '\n')), labelled.size());
}

}  // namespace MAPLESS_FILE
}  // namespace mapless::app
