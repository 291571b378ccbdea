#include "run/result_tables.hpp"

#include <utility>

#include "run/lost_motion.hpp"
#include "run/scan_poses.hpp"
#include <mapless/core/errors.hpp>

namespace mapless::app {
namespace {

TableRows rows_of(const LabelledScan& labelled, std::size_t k, std::vector<TimedPose> poses) {
  const Detection& detection = labelled.detection;
  TableRows rows = {object_rows(k, detection.tracked), std::move(poses), std::nullopt};
  if (labelled.odometry) {
    const double duration_s = (detection.scan->end() - detection.scan->start).seconds();
    rows.motion = motion_row(k, rows.poses.front(), duration_s, *labelled.odometry);
  }
  return rows;
}

}  // namespace

ResultTables::ResultTables(const ResultFolder& result, TableChoice choice, GrowingFile::Start start)
    : kitti_(result.kitti_poses(), "", start), trajectory_(result.trajectory(), "", start) {
  if (choice.objects) objects_.emplace(result.objects(), start);
  if (choice.motions) motions_.emplace(result.poses(), kMotionTableHead, start);
}

void ResultTables::add(const TableRows& rows) {
  if (objects_) objects_->add(rows.objects);
  const std::vector<TimedPose> before = unwritten_before(rows.poses);
  trajectory_.append(tum_rows(before));
  settle(before);
  kitti_.append(kitti_rows({rows.poses.front()}));
  try {
    if (motions_) motions_->append(motion_table_rows({*rows.motion}));
  } catch (const OutputError&) {
    kitti_.undo_append();
    throw;
  }
  unwritten_ = rows.poses;
}

void ResultTables::verify(const TableRows& rows) {
  if (objects_) objects_->verify(rows.objects);
  const std::vector<TimedPose> before = unwritten_before(rows.poses);
  trajectory_.verify(tum_rows(before));
  settle(before);
  kitti_.verify(kitti_rows({rows.poses.front()}));
  if (motions_) motions_->verify(motion_table_rows({*rows.motion}));
  unwritten_ = rows.poses;
}

void ResultTables::undo_add() {
  unwritten_.clear();
  kitti_.undo_append();
  if (motions_) motions_->undo_append();
}

void ResultTables::finish(const Trajectory& trajectory, Time end) {
  std::vector<TimedPose> rows = last_written_;
  rows.insert(rows.end(), unwritten_.begin(), unwritten_.end());
  append_last_pose(rows, trajectory, end);
  rows.erase(rows.begin(), rows.begin() + static_cast<std::ptrdiff_t>(last_written_.size()));
  trajectory_.append(tum_rows(rows));
  settle(rows);
}

// The poses of the last scan that come before those of the next.
std::vector<TimedPose> ResultTables::unwritten_before(const std::vector<TimedPose>& next) const {
  std::vector<TimedPose> before = unwritten_;
  while (!next.empty() && !before.empty() && before.back().time >= next.front().time) before.pop_back();
  return before;
}

void ResultTables::settle(const std::vector<TimedPose>& written) {
  unwritten_.clear();
  poses_ += written.size();
  if (!written.empty()) last_written_ = {written.back()};
}

ScanFiles files_of(const LabelledScan& labelled, std::size_t k, std::vector<TimedPose> poses,
                   bool probabilities) {
  const Detection& detection = labelled.detection;
  ScanFiles files = {stage_masks_of(detection), labels_of(detection, detection.tracked), std::nullopt,
                     rows_of(labelled, k, std::move(poses))};
  if (probabilities) files.probabilities = labelled.probability_by_input();
  return files;
}

void write_files(const ResultFolder& result, std::size_t k, const ScanFiles& files, ResultTables& tables) {
  write_stage_file(result.stage_file(k), files.stages);
  if (files.probabilities) write_probability_file(result.probability_file(k), *files.probabilities);
  tables.add(files.rows);
  try {
    write_label_file(result.label_file(k), files.labels);
  } catch (const OutputError&) {
    tables.undo_add();
    throw;
  }
}

}  // namespace mapless::app
