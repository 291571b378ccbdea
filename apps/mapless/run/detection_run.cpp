#include "run/detection_run.hpp"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <utility>

#include "run/scan_poses.hpp"
#include "terminal/interrupt.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/core/time.hpp>
#include <mapless/geometry/compensated_scan.hpp>
#include <mapless/io/files.hpp>
#include <mapless/io/labels.hpp>
#include <mapless/io/result_folder.hpp>

namespace mapless::app {
namespace {

// Bounds the memory where writing is slower than detecting: a scan and its labels are about 10 MB.
constexpr std::size_t kMostUnwritten = 4;

}  // namespace

DetectionRun::DetectionRun(const Dataset& dataset, std::shared_ptr<const Trajectory> given,
                           const ResultFolder& result, const OnlineDetectorOptions& options,
                           RunSummary& summary, ScanSelection selection, std::optional<RealTimePace> pace,
                           std::function<void()> make_folder, std::size_t finished_before)
    : dataset_(dataset),
      given_(std::move(given)),
      result_(result),
      selection_(selection),
      make_folder_(std::move(make_folder)),
      finished_before_(finished_before),
      online_(options),
      pace_(std::move(pace)),
      summary_(summary),
      progress_("scans"),
      reader_([this](std::size_t k) { return read(k); }, selection.own_vehicle_from,
              selection.first - selection.own_vehicle_from + selection.count),
      writer_(kMostUnwritten, [this](const FinishedScan& scan) { write(scan); }) {}

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
  if (summary_.scans() == 0 || summary_.scans() < finished_before_) return;
  tables_->finish(*last_trajectory_, last_end_);
  if (!given_) summary_.set_odometry(online_.odometry_report());
  input_output_.reading = reader_.busy();
  input_output_.writing = writer_.busy();
  summary_.set_input_output(input_output_);
  summary_.set_scan_doubts(watch_.lines());
  if (pace_) summary_.set_real_time(pace_->report());
  write_file_atomically(result_.summary(), summary_.text());
}

bool DetectionRun::detect_all() {
  try {
    if (!push_all()) {
      finish(online_.catch_up());
      return false;
    }
  } catch (...) {
    finish(online_.catch_up());  // the scans before the one that failed
    throw;
  }
  finish(online_.flush());
  return true;
}

void DetectionRun::learn_own_vehicle() {
  for (std::size_t k = selection_.own_vehicle_from; k < selection_.first && !InterruptGuard::requested(); ++k)
    online_.learn_own_vehicle(*take(k), *given_);
}

bool DetectionRun::push_all() {
  learn_own_vehicle();
  while (const auto index = next_scan()) {
    if (InterruptGuard::requested()) return false;
    const std::size_t k = selection_.first + *index;
    const std::shared_ptr<const LidarScan> scan = take(k);
    numbers_.push_back(k);
    finish(online_.push(scan, given_));
    if (!next_is_ready()) finish(online_.catch_up());
  }
  return !InterruptGuard::requested();
}

// Index in the selection.
std::optional<std::size_t> DetectionRun::next_scan() {
  if (pace_) return pace_->next(InterruptGuard::requested);
  return next_ < selection_.count ? std::optional(next_++) : std::nullopt;
}

bool DetectionRun::next_is_ready() const { return pace_ ? pace_->next_is_due() : reader_.is_ready(); }

// On the thread that reads, which has time for it.
InputScan DetectionRun::read(std::size_t k) {
  LidarScan scan = dataset_.read(k);
  watch_.add(scan, k);
  const bool restore = scan.compensated_to && given_;
  if (restore) scan = restore_measured_rays(scan, *given_);
  return {std::make_shared<const LidarScan>(std::move(scan)), restore};
}

std::shared_ptr<const LidarScan> DetectionRun::take(std::size_t k) {
  const InputScan input = timed(input_output_.waited_for_reading_s, [&] { return reader_.take(k); });
  if (!std::exchange(input_known_, true)) summary_.set_input(*input.scan, input.was_compensated);
  return input.scan;
}

void DetectionRun::finish(std::vector<LabelledScan> scans) {
  for (LabelledScan& labelled : scans) {
    const LidarScan& scan = labelled.scan();
    FinishedScan finished;
    finished.k = numbers_.front();
    numbers_.pop_front();
    finished.poses = scan_poses(*labelled.trajectory, scan.start, scan.end(), kPosesPerScan);
    finished.labelled = std::move(labelled);
    if (pace_) pace_->answered(finished.k - selection_.first);
    timed(input_output_.waited_for_writing_s, [&] { writer_.add(std::move(finished)); });
  }
}

void DetectionRun::write(const FinishedScan& scan) {
  if (!tables_) {
    if (finished_before_ == 0) make_folder_();
    tables_.emplace(result_, TableChoice{true, !given_},
                    finished_before_ > 0 ? GrowingFile::Start::resumed : GrowingFile::Start::anew);
  }
  const Detection& detection = scan.labelled.detection;
  const ScanFiles files = files_of(scan.labelled, scan.k, scan.poses, probabilities_);
  if (summary_.scans() < finished_before_) {
    verify(scan.k, files);
  } else {
    write_files(result_, scan.k, files, *tables_);
  }
  summary_.add(detection);
  last_trajectory_ = scan.labelled.trajectory;
  last_end_ = detection.scan->end();
  progress_.update(summary_.scans(), selection_.count);
}

// The scan was finished by the earlier run.
void DetectionRun::verify(std::size_t k, const ScanFiles& files) {
  const auto refuse = [](const std::filesystem::path& file) {
    throw InputError({file.string(), "content", "",
                      "differs from what this run computes: the file or the recording has changed",
                      "start anew with --overwrite"});
  };
  const std::string stages = read_whole_file(result_.stage_file(k));
  if (!std::equal(stages.begin(), stages.end(), files.stages.begin(), files.stages.end(),
                  [](char a, std::uint8_t b) { return static_cast<std::uint8_t>(a) == b; }))
    refuse(result_.stage_file(k));
  if (read_label_file(result_.label_file(k), files.labels.size()) != files.labels)
    refuse(result_.label_file(k));
  if (files.probabilities) {
    const auto before = read_probability_file(result_.probability_file(k), files.probabilities->size());
    if (std::memcmp(before.data(), files.probabilities->data(), before.size() * sizeof(float)) != 0)
      refuse(result_.probability_file(k));
  }
  tables_->verify(files.rows);
}

}  // namespace mapless::app
