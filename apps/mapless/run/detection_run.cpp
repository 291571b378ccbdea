#include "run/detection_run.hpp"

#include <utility>

#include "run/scan_poses.hpp"
#include "terminal/interrupt.hpp"
#include <mapless/core/time.hpp>
#include <mapless/geometry/compensated_scan.hpp>
#include <mapless/io/files.hpp>
#include <mapless/io/labels.hpp>
#include <mapless/io/result_folder.hpp>

namespace mapless::app {
namespace {

constexpr std::size_t kMostUnwritten = 4;

}  // namespace

DetectionRun::DetectionRun(const Dataset& dataset, MotionSource& motion, const ResultFolder& result,
                           const DetectorParameters& parameters, RunSummary& summary, ScanSelection selection,
                           bool side_by_side, std::optional<RealTimePace> pace,
                           std::function<void()> make_folder)
    : dataset_(dataset),
      motion_(motion),
      result_(result),
      selection_(selection),
      make_folder_(std::move(make_folder)),
      pace_(std::move(pace)),
      detector_(parameters),
      summary_(summary),
      progress_("scans"),
      reader_([this](std::size_t k) { return read(k); }, selection.first, selection.count),
      writer_(kMostUnwritten, [this](const FinishedScan& scan) { write(scan); }) {
  if (side_by_side && motion.estimated()) side_.emplace();
}

bool DetectionRun::run() {
  const auto settle = [&] {
    reader_.stop();
    timed(input_output_.waited_for_writing_s, [&] { writer_.join(); });
  };
  return timed(input_output_.run_s, [&] {
    try {
      const bool complete = detect_all();
      settle();
      writer_.finish();
      return complete;
    } catch (...) {
      settle();
      throw;
    }
  });
}

void DetectionRun::write_outcome() {
  progress_.clear();
  if (!objects_) return;
  write_kitti_poses(result_.kitti_poses(), poses_);
  std::vector<TimedPose> rows = rows_;
  append_last_pose(rows, motion_.trajectory(), last_end_);
  write_tum_trajectory(result_.trajectory(), rows);
  if (motion_.estimated()) summary_.set_odometry(motion_.report());
  input_output_.reading = reader_.busy();
  input_output_.writing = writer_.busy();
  summary_.set_input_output(input_output_);
  if (pace_) summary_.set_real_time(pace_->report());
  write_file_atomically(result_.summary(), summary_.text());
}

// Index in the selection.
std::optional<std::size_t> DetectionRun::next_scan() {
  if (pace_) return pace_->next(InterruptGuard::requested);
  return next_ < selection_.count ? std::optional(next_++) : std::nullopt;
}

bool DetectionRun::detect_all() {
  try {
    const bool complete = detect_scans();
    end_detection();
    if (!complete) return false;
  } catch (...) {
    end_detection();  // where the detection of the scans before failed too, that came first
    throw;
  }
  for (Detection& detection : detector_.flush()) {
    if (InterruptGuard::requested()) return false;
    finish_scan(std::move(detection), motion_.trajectory());
  }
  return true;
}

bool DetectionRun::detect_scans() {
  while (const auto index = next_scan()) {
    if (InterruptGuard::requested()) return false;
    const auto scans = motion_.add(take(selection_.first + *index));
    end_detection();
    begin_detection(scans);
    if (scans.size() > 1) end_detection();  // odometry has just begun: what moves is all over its map
  }
  if (InterruptGuard::requested()) return false;
  end_detection();
  begin_detection(motion_.flush());
  return true;
}

// A trajectory that was given does not change; one that is estimated is not asked here.
InputScan DetectionRun::read(std::size_t k) const {
  LidarScan scan = dataset_.read(k);
  const bool restore = scan.compensated_to && !motion_.estimated();
  if (restore) scan = restore_measured_rays(scan, motion_.trajectory());
  return {std::make_shared<const LidarScan>(std::move(scan)), restore};
}

std::shared_ptr<const LidarScan> DetectionRun::take(std::size_t k) {
  const InputScan input = timed(input_output_.waited_for_reading_s, [&] { return reader_.take(k); });
  if (!std::exchange(input_known_, true)) summary_.set_input(*input.scan, input.was_compensated);
  taken_.push_back(k);
  unfinished_.push_back(input.scan->start);
  return input.scan;
}

// Scans whose motion is known now: one after another, but for the first ones of an odometry.
void DetectionRun::begin_detection(const std::vector<std::shared_ptr<const LidarScan>>& scans) {
  if (scans.empty()) return;
  const auto count = static_cast<std::ptrdiff_t>(scans.size());
  numbers_.insert(numbers_.end(), taken_.begin(), taken_.begin() + count);
  taken_.erase(taken_.begin(), taken_.begin() + count);
  const auto detect = [this, scans, trajectory = motion_.known_from(unfinished_.front())] {
    for (const auto& scan : scans) {
      if (InterruptGuard::requested()) return;
      for (Detection& detection : detector_.process(scan, *trajectory))
        finish_scan(std::move(detection), *trajectory);
    }
  };
  if (!side_) return detect();
  side_->start(detect);
  detecting_ = true;
}

// What was found moving leaves odometry's map now, whenever it was found.
void DetectionRun::end_detection() {
  if (std::exchange(detecting_, false)) side_->wait();
  for (const auto& detection : std::exchange(found_, {})) {
    motion_.leave_out(*detection);
    unfinished_.pop_front();
  }
}

void DetectionRun::finish_scan(Detection detection, const Trajectory& trajectory) {
  FinishedScan finished;
  finished.k = numbers_.front();
  numbers_.pop_front();
  finished.poses = scan_poses(trajectory, detection.scan->start, detection.scan->end(), kPosesPerScan);
  finished.detection = std::make_shared<const Detection>(std::move(detection));
  found_.push_back(finished.detection);
  if (pace_) pace_->answered(finished.k - selection_.first);
  timed(input_output_.waited_for_writing_s, [&] { writer_.add(std::move(finished)); });
}

void DetectionRun::write(const FinishedScan& scan) {
  if (!objects_) {
    make_folder_();
    objects_.emplace(result_.objects());
  }
  objects_->add(object_rows(scan.k, scan.detection->tracked));
  write_stage_file(result_.stage_file(scan.k), stage_masks_of(*scan.detection));
  write_label_file(result_.label_file(scan.k), labels_of(*scan.detection, scan.detection->tracked));
  summary_.add(*scan.detection);
  poses_.push_back(scan.poses.front());
  append_poses(rows_, scan.poses);
  last_end_ = scan.detection->scan->end();
  progress_.update(summary_.scans(), selection_.count);
}

}  // namespace mapless::app
