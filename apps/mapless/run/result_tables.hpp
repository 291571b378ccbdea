#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include <mapless/io/labels.hpp>
#include <mapless/io/result_folder.hpp>
#include <mapless/io/trajectory_file.hpp>
#include <mapless/pipeline/online_detector.hpp>

namespace mapless::app {

/// What one scan adds to the tables of a result.
struct TableRows {
  std::vector<ObjectRow> objects;
  std::vector<TimedPose> poses;     ///< within the scan, the first at its start
  std::optional<MotionRow> motion;  ///< where poses.csv is written
};

/// Which tables beside poses_kitti.txt and trajectory.txt.
struct TableChoice {
  bool objects = true;   ///< objects.csv
  bool motions = false;  ///< poses.csv, along own odometry
};

/// The tables of a result: poses_kitti.txt, trajectory.txt, and those chosen. Each scan's rows are on the
/// disk when `add` returns, except those of trajectory.txt: they are written with the next scan, whose first
/// pose replaces the poses of this scan that are not before it. Memory does not grow with the number of
/// scans.
class ResultTables {
 public:
  /// Creates the files, or goes on with those of an earlier run. Throws as GrowingFile does.
  ResultTables(const ResultFolder& result, TableChoice choice, GrowingFile::Start start);

  /// Appends the rows of the next scan. Throws OutputError.
  void add(const TableRows& rows);
  /// For a scan that the earlier run finished: throws InputError where the files do not hold its rows next.
  void verify(const TableRows& rows);
  /// Removes the poses of the scan added last, which could not be finished. Throws OutputError.
  void undo_add();
  /// Appends the rest of trajectory.txt: the poses of the last scan, and the last pose of `trajectory` at
  /// `end` at most. Throws OutputError.
  void finish(const Trajectory& trajectory, Time end);

  /// Number of rows of trajectory.txt.
  [[nodiscard]] std::size_t poses() const { return poses_; }

 private:
  [[nodiscard]] std::vector<TimedPose> unwritten_before(const std::vector<TimedPose>& next) const;
  void settle(const std::vector<TimedPose>& written);

  std::optional<ObjectTableWriter> objects_;
  GrowingFile kitti_, trajectory_;
  std::optional<GrowingFile> motions_;
  std::vector<TimedPose> unwritten_;  // of the last scan, for trajectory.txt
  std::size_t poses_ = 0;
  std::vector<TimedPose> last_written_;  // the last row of trajectory.txt, if there is one
};

/// What a labelled scan adds to the files of a result.
struct ScanFiles {
  std::vector<std::uint8_t> stages;
  std::vector<std::uint32_t> labels;
  std::optional<std::vector<float>> probabilities;
  TableRows rows;
};

/// `k`: number of the scan in its recording. `poses`: those within it (scan_poses). `probabilities`: whether
/// they are wanted.
[[nodiscard]] ScanFiles files_of(const LabelledScan& labelled, std::size_t k, std::vector<TimedPose> poses,
                                 bool probabilities);

/// Writes the files of scan k and appends its rows; its label file last, so that the labelled scans of a run
/// that is stopped are complete. Throws OutputError.
void write_files(const ResultFolder& result, std::size_t k, const ScanFiles& files, ResultTables& tables);

}  // namespace mapless::app
