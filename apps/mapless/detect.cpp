#include <chrono>
#include <cmath>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <tbb/global_control.h>

#include "interrupt.hpp"
#include "motion_source.hpp"
#include "option_checks.hpp"
#include "parameter_options.hpp"
#include "progress.hpp"
#include "recording_options.hpp"
#include "run_summary.hpp"
#include "scan_poses.hpp"
#include "verbs.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/detection/detector.hpp>
#include <mapless/detection/object_tracker.hpp>
#include <mapless/geometry/compensated_scan.hpp>
#include <mapless/io/atomic_file.hpp>
#include <mapless/io/detection_labels.hpp>
#include <mapless/io/labels.hpp>
#include <mapless/io/object_table.hpp>
#include <mapless/io/result_folder.hpp>
#include <mapless/io/time_order.hpp>

namespace mapless::app {
namespace {

struct DetectOptions {
  RecordingOptions recording;
  TrajectoryRequest trajectory;
  ParameterOptions parameters;
  std::string output;
  std::size_t first = 0;
  std::optional<std::size_t> count;
  std::optional<std::size_t> threads;
  bool odometry = false;
  bool overwrite = false;
  bool json = false;
};

std::size_t selected_count(const DetectOptions& options, const Dataset& dataset) {
  const std::size_t available = dataset.size();
  const std::string remedy = fmt::format("the recording has {} scans", available);
  if (options.first >= available) {
    throw ParameterError({"--first", "", std::to_string(options.first), "there is no such scan", remedy});
  }
  const std::size_t count = options.count.value_or(available - options.first);
  if (count > available - options.first) {
    throw ParameterError({"--count", "", std::to_string(count),
                          fmt::format("there are not so many scans from scan {} on", options.first), remedy});
  }
  return count;
}

/// One run: scans in, files out.
class DetectionRun {
 public:
  DetectionRun(const Dataset& dataset, MotionSource& motion, const ResultFolder& result,
               const DetectorParameters& parameters, RunSummary& summary, std::size_t first,
               std::size_t count, std::function<void()> make_folder)
      : dataset_(dataset),
        motion_(motion),
        result_(result),
        detector_(parameters),
        summary_(summary),
        first_(first),
        count_(count),
        make_folder_(std::move(make_folder)),
        progress_("scans") {}

  /// False where it was interrupted: what is finished is written, what is not is not.
  bool run() {
    for (std::size_t k = first_; k < first_ + count_; ++k) {
      if (InterruptGuard::requested()) return false;
      if (!detect(motion_.add(read(k)))) return false;
    }
    if (!detect(motion_.flush())) return false;
    while (const auto detection = detector_.flush()) {
      if (InterruptGuard::requested()) return false;
      finish_scan(*detection);
    }
    return true;
  }

  /// Poses and summary of the scans finished so far; nothing where not one was.
  void write_outcome() {
    progress_.clear();
    if (!objects_) return;
    write_kitti_poses(result_.kitti_poses(), poses_);
    std::vector<TimedPose> rows = rows_;
    append_last_pose(rows, motion_.trajectory(), last_end_);
    write_tum_trajectory(result_.trajectory(), rows);
    if (motion_.estimated()) summary_.set_odometry(motion_.report());
    write_file_atomically(result_.summary(), summary_.text());
  }

 private:
  [[nodiscard]] std::shared_ptr<const LidarScan> read(std::size_t k) {
    LidarScan scan = dataset_.read(k);
    summary_.add_input(scan);
    if (scan.compensated_to && !motion_.estimated()) scan = restore_measured_rays(scan, motion_.trajectory());
    return std::make_shared<const LidarScan>(std::move(scan));
  }

  // Scans whose motion is known now: one after another, but for the first ones of an odometry.
  bool detect(const std::vector<std::shared_ptr<const LidarScan>>& scans) {
    for (const auto& scan : scans) {
      if (InterruptGuard::requested()) return false;
      if (const auto detection = detector_.process(scan, motion_.trajectory())) finish_scan(*detection);
    }
    return true;
  }

  void finish_scan(const Detection& detection) {
    motion_.leave_out(detection);
    if (!objects_) {
      make_folder_();
      objects_.emplace(result_.objects());
    }
    const auto start = std::chrono::steady_clock::now();
    const std::vector<TrackedObject> objects = tracker_.process(detection, motion_.trajectory());
    const std::chrono::duration<double> tracking = std::chrono::steady_clock::now() - start;
    const std::size_t k = first_ + detection.sequence_number;
    objects_->add(object_rows(k, objects));
    write_stage_file(result_.stage_file(k), stage_masks_of(detection));
    write_label_file(result_.label_file(k), labels_of(detection, objects));
    summary_.add(detection, objects, tracking.count());
    poses_.push_back({detection.scan->start, motion_.trajectory().at(detection.scan->start).T_v0});
    last_end_ = detection.scan->end();
    append_scan_poses(rows_, motion_.trajectory(), detection.scan->start, last_end_, kPosesPerScan);
    progress_.update(summary_.scans(), count_);
  }

  const Dataset& dataset_;
  MotionSource& motion_;
  const ResultFolder& result_;
  Detector detector_;
  ObjectTracker tracker_;
  std::optional<ObjectTableWriter> objects_;  // where the folder is made
  RunSummary& summary_;
  std::size_t first_, count_;
  std::function<void()> make_folder_;
  Progress progress_;
  std::vector<TimedPose> poses_, rows_;  // at the start of each scan, and within it
  Time last_end_;
};

void announce(const Dataset& dataset, const MotionSource& motion) {
  fmt::print(stderr, "mapless: format {}, sensor {}, {} scans\n", dataset.format(), dataset.model()->name,
             dataset.size());
  for (const std::string& note : dataset.notes()) fmt::print(stderr, "mapless: {}\n", note);
  if (motion.estimated()) {
    fmt::print(stderr, "mapless: trajectory: estimated by lidar odometry\n");
    return;
  }
  std::string line;
  for (const auto& [name, value] : motion.source().conventions) {
    line += fmt::format("{}{} {}", line.empty() ? "" : ", ", name, value);
  }
  fmt::print(stderr, "mapless: trajectory: {}\n", line);
}

int report(const DetectOptions& options, const RunSummary& summary, bool complete) {
  if (!complete && summary.scans() == 0) {
    fmt::print(stderr, "mapless: interrupted before the first scan was finished; nothing is written\n");
    return InterruptGuard::exit_code();
  }
  if (!complete) {
    fmt::print(stderr,
               "mapless: interrupted after {} finished scans; they are valid, the summary says incomplete\n",
               summary.scans());
    return InterruptGuard::exit_code();
  }
  if (options.json) {
    fmt::print("{}", summary.text());
  } else {
    fmt::print("{}result in {}\n", summary.lines(), options.output);
  }
  return 0;
}

bool run_to_the_end(DetectionRun& run, RunSummary& summary) {
  try {
    const bool complete = run.run();
    if (complete) {
      summary.set_complete();
    } else {
      summary.set_stopped("interrupted");
    }
    run.write_outcome();
    return complete;
  } catch (const std::exception& error) {
    summary.set_stopped(error.what());
    try {
      run.write_outcome();
    } catch (const OutputError&) {  // the first error is the one to report
    }
    throw;
  }
}

int detect(const DetectOptions& options) {
  std::optional<tbb::global_control> threads;
  if (options.threads) threads.emplace(tbb::global_control::max_allowed_parallelism, *options.threads);
  const ResultFolder result(options.output);
  result.require_free(options.overwrite);
  const DetectorParameters parameters = options.parameters.chosen();

  const auto dataset = options.recording.open();
  const std::size_t count = selected_count(options, *dataset);
  require_time_order(*dataset, options.first, count);
  MotionSource motion = options.odometry ? MotionSource::odometry(options.parameters.odometry())
                                         : MotionSource(*dataset, options.trajectory, options.first,
                                                        options.parameters.odometry());
  announce(*dataset, motion);
  if (!motion.estimated()) require_coverage(*dataset, motion.trajectory(), options.first, count);

  const InterruptGuard interrupt;
  RunSummary summary(*dataset, options.recording.path, motion.source(), options.parameters.profile,
                     options.first, count);
  // Not before there is a scan to write: a run that fails earlier leaves nothing behind, and an earlier
  // result as it is.
  const auto make_folder = [&] {
    result.create(options.overwrite, summary.text());
    write_file_atomically(result.config(), configuration_text(options.parameters));
  };
  DetectionRun run(*dataset, motion, result, parameters, summary, options.first, count, make_folder);
  const bool complete = run_to_the_end(run, summary);
  if (const std::string trouble = motion.trouble(); !trouble.empty())
    fmt::print(stderr, "mapless: {}\n", trouble);
  return report(options, summary, complete);
}

}  // namespace

void add_detect(CLI::App& app, int& exit_code) {
  auto* verb =
      app.add_subcommand("detect",
                         "Label every point of a recording as dynamic or static, and follow what moves: "
                         "its place and velocity scan by scan (objects.csv)");
  const auto options = std::make_shared<DetectOptions>();
  add_recording_options(*verb, options->recording);
  verb->add_option("-o,--output", options->output,
                   "folder for the result; must not exist, but for --overwrite")
      ->required();
  verb->add_flag("--overwrite", options->overwrite, "replace an earlier result in that folder");
  add_trajectory_options(*verb, options->trajectory);
  verb->add_flag("--odometry", options->odometry,
                 "estimate the trajectory from the scans even where the recording brings one")
      ->group("Trajectory")
      ->excludes("--trajectory")
      ->excludes("--stationary");
  add_parameter_options(*verb, options->parameters);
  verb->add_flag("--causal", options->parameters.causal,
                 "answer for each scan at once, without the forward check: forward_gap = 0");
  verb->add_option("--first", options->first, "number of the first scan used; those before it are not read")
      ->check(whole_number(0))
      ->capture_default_str();
  verb->add_option("--count", options->count, "how many scans (all from the first on where not given)")
      ->check(whole_number(1));
  verb->add_option("--threads", options->threads,
                   "threads used (all cores where not given); the result is the same")
      ->check(CLI::Range(1, 1024));
  verb->add_flag("--json", options->json, "print the summary as JSON");
  verb->callback([options, &exit_code] { exit_code = detect(*options); });
}

}  // namespace mapless::app
