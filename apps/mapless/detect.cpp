#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <tbb/global_control.h>

#include "interrupt.hpp"
#include "option_checks.hpp"
#include "parameter_options.hpp"
#include "progress.hpp"
#include "recording_options.hpp"
#include "run_summary.hpp"
#include "verbs.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/detection/detector.hpp>
#include <mapless/geometry/compensated_scan.hpp>
#include <mapless/io/atomic_file.hpp>
#include <mapless/io/detection_labels.hpp>
#include <mapless/io/labels.hpp>
#include <mapless/io/result_folder.hpp>
#include <mapless/io/time_order.hpp>

namespace mapless::app {
namespace {

constexpr int kInterrupted = 130;

struct DetectOptions {
  RecordingOptions recording;
  TrajectoryRequest trajectory;
  ParameterOptions parameters;
  std::string output;
  std::size_t first = 0;
  std::optional<std::size_t> count;
  std::optional<std::size_t> threads;
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
  DetectionRun(const Dataset& dataset, const Trajectory& trajectory, const ResultFolder& result,
               const DetectorParameters& parameters, RunSummary& summary, std::size_t first,
               std::size_t count)
      : dataset_(dataset),
        trajectory_(trajectory),
        result_(result),
        detector_(parameters),
        summary_(summary),
        first_(first),
        count_(count),
        progress_("scans") {}

  /// False where it was interrupted: what is finished is written, what is not is not.
  bool run() {
    for (std::size_t k = first_; k < first_ + count_; ++k) {
      if (InterruptGuard::requested()) return false;
      if (const auto detection = detector_.process(read(k), trajectory_)) finish_scan(*detection);
    }
    while (const auto detection = detector_.flush()) {
      if (InterruptGuard::requested()) return false;
      finish_scan(*detection);
    }
    return true;
  }

  /// Poses and summary of the scans finished so far.
  void write_outcome() {
    progress_.clear();
    write_kitti_poses(result_.kitti_poses(), poses_);
    std::vector<TimedPose> rows = poses_;
    if (!rows.empty() && last_end_ > rows.back().time)
      rows.push_back({last_end_, trajectory_.at(last_end_).T_v0});
    write_tum_trajectory(result_.trajectory(), rows);
    write_file_atomically(result_.summary(), summary_.text());
  }

 private:
  [[nodiscard]] std::shared_ptr<const LidarScan> read(std::size_t k) {
    LidarScan scan = dataset_.read(k);
    summary_.add_input(scan);
    if (scan.compensated_to) scan = restore_measured_rays(scan, trajectory_);
    return std::make_shared<const LidarScan>(std::move(scan));
  }

  void finish_scan(const Detection& detection) {
    const std::size_t k = first_ + detection.sequence_number;
    write_stage_file(result_.stage_file(k), stage_masks_of(detection));
    write_label_file(result_.label_file(k), labels_of(detection));
    summary_.add(detection);
    poses_.push_back({detection.scan->start, trajectory_.at(detection.scan->start).T_v0});
    last_end_ = std::min(detection.scan->end(), trajectory_.end());
    progress_.update(summary_.scans(), count_);
  }

  const Dataset& dataset_;
  const Trajectory& trajectory_;
  const ResultFolder& result_;
  Detector detector_;
  RunSummary& summary_;
  std::size_t first_, count_;
  Progress progress_;
  std::vector<TimedPose> poses_;
  Time last_end_;
};

void announce(const Dataset& dataset, const TrajectorySource& trajectory) {
  fmt::print(stderr, "mapless: format {}, sensor {}, {} scans\n", dataset.format(), dataset.model()->name,
             dataset.size());
  for (const std::string& note : dataset.notes()) fmt::print(stderr, "mapless: {}\n", note);
  std::string line;
  for (const auto& [name, value] : trajectory.conventions) {
    line += fmt::format("{}{} {}", line.empty() ? "" : ", ", name, value);
  }
  fmt::print(stderr, "mapless: trajectory: {}\n", line);
}

int report(const DetectOptions& options, const RunSummary& summary, bool complete) {
  if (!complete) {
    fmt::print(stderr,
               "mapless: interrupted after {} finished scans; they are valid, the summary says incomplete\n",
               summary.scans());
    return kInterrupted;
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
  const TrajectorySource trajectory = open_trajectory(*dataset, options.trajectory);
  announce(*dataset, trajectory);
  require_coverage(*dataset, *trajectory.trajectory, options.first, count);

  const InterruptGuard interrupt;
  RunSummary summary(*dataset, options.recording.path, trajectory, options.parameters.profile, options.first,
                     count);
  result.create(options.overwrite, summary.text());
  write_file_atomically(result.config(), configuration_text(parameters));
  DetectionRun run(*dataset, *trajectory.trajectory, result, parameters, summary, options.first, count);
  return report(options, summary, run_to_the_end(run, summary));
}

}  // namespace

void add_detect(CLI::App& app, int& exit_code) {
  auto* verb = app.add_subcommand("detect", "Label every point of a recording as dynamic or static");
  const auto options = std::make_shared<DetectOptions>();
  add_recording_options(*verb, options->recording);
  verb->add_option("-o,--output", options->output,
                   "folder for the result; must not exist, but for --overwrite")
      ->required();
  verb->add_flag("--overwrite", options->overwrite, "replace an earlier result in that folder");
  add_trajectory_options(*verb, options->trajectory);
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
