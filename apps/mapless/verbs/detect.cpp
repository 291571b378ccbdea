#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <tbb/global_control.h>

#include "export/semantic_kitti.hpp"
#include "options/motion_measurements.hpp"
#include "options/option_checks.hpp"
#include "options/parameter_options.hpp"
#include "options/recording_options.hpp"
#include "rig/rig_run.hpp"
#include "run/detection_run.hpp"
#include "run/earlier_run.hpp"
#include "run/folder_lock.hpp"
#include "run/given_motion.hpp"
#include "run/lost_motion.hpp"
#include "run/run_summary.hpp"
#include "terminal/exit_codes.hpp"
#include "terminal/interrupt.hpp"
#include "terminal/stderr.hpp"
#include "trust/input_check.hpp"
#include "verbs/verbs.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/dataset.hpp>
#include <mapless/io/files.hpp>
#include <mapless/io/result_folder.hpp>

namespace mapless::app {
namespace {

struct DetectOptions {
  RecordingOptions recording;
  TrajectoryRequest trajectory;
  ParameterOptions parameters;
  MotionMeasurementOptions measured;
  std::string output;
  std::string semantic_kitti;  // folder; empty: not wanted
  std::size_t first = 0;
  std::optional<std::size_t> count;
  std::optional<std::size_t> own_vehicle_from;
  std::optional<std::size_t> threads;
  bool odometry = false;
  bool real_time = false;
  bool overwrite = false;
  bool resume = false;
  bool probability = false;
  bool json = false;
};

std::size_t selected_count(const DetectOptions& options, const Dataset& dataset) {
  const std::size_t available = dataset.size();
  const std::string remedy = fmt::format("the recording has {} scans", available);
  if (options.first >= available) {
    throw ParameterError({"--first", "", std::to_string(options.first), "no such scan", remedy});
  }
  const std::size_t count = options.count.value_or(available - options.first);
  if (count > available - options.first) {
    throw ParameterError({"--count", "", std::to_string(count),
                          fmt::format("more scans than there are from scan {} on", options.first), remedy});
  }
  return count;
}

// The first scan from which the own vehicle is learnt.
std::size_t own_vehicle_from(const DetectOptions& options, const TrajectorySource& motion) {
  const std::size_t from = options.own_vehicle_from.value_or(options.first);
  if (from > options.first) {
    throw ParameterError({"--own-vehicle-from", "", std::to_string(from), "after the first scan to process",
                          fmt::format("--first is {}", options.first)});
  }
  if (from < options.first && !motion.trajectory) {
    throw ParameterError(
        {"--own-vehicle-from", "", std::to_string(from), "needs poses", "give poses, or leave it out"});
  }
  return from;
}

// Measurements are for the odometry.
std::vector<MotionMeasurement> measurements_of(const DetectOptions& options, const Dataset& dataset,
                                               const TrajectorySource& motion, std::size_t count) {
  if (motion.trajectory && (options.measured.any() || !dataset.measurements().empty())) {
    throw ParameterError({"--initial-velocity, --speed, --imu or their topics", "", "given",
                          "poses are given as well", "give --odometry to estimate the motion"});
  }
  return options.measured.measurements(dataset, options.first, count);
}

void announce(const Dataset& dataset, const TrajectorySource& motion) {
  say("mapless: format {}, sensor {}, {} scans\n", dataset.format(), dataset.model()->name, dataset.size());
  for (const std::string& note : dataset.notes()) say("mapless: {}\n", note);
  if (!motion.trajectory) {
    say("mapless: trajectory: estimated by lidar odometry\n");
    return;
  }
  std::string line;
  for (const auto& [name, value] : motion.conventions) {
    line += fmt::format("{}{} {}", line.empty() ? "" : ", ", name, value);
  }
  say("mapless: trajectory: {}\n", line);
}

int report(const DetectOptions& options, const RunSummary& summary, bool complete,
           std::size_t finished_before) {
  if (!complete && summary.scans() < finished_before) {
    say("mapless: interrupted before the scans finished earlier were computed again; the result is as it "
        "was\n");
    return InterruptGuard::exit_code();
  }
  if (!complete && summary.scans() == 0) {
    say("mapless: interrupted before the first scan was finished; nothing is written\n");
    return InterruptGuard::exit_code();
  }
  if (!complete) {
    say("mapless: interrupted after {} finished scans; their results are valid, summary.json says "
        "incomplete\n",
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

// Says the doubts from line number `said` on: those before have been said.
int trust(const std::vector<std::string>& doubts, std::size_t said) {
  for (std::size_t i = said; i < doubts.size(); ++i) say("mapless: {}\n", doubts[i]);
  if (doubts.empty()) return kSuccess;
  say("mapless: finished; the result is doubtful, see above\n");
  return kNotTrusted;
}

// Says what --resume will do.
void announce(const std::optional<EarlierRun>& earlier, const std::string& output) {
  if (!earlier) {
    say("mapless: --resume: no finished scan in {}, starts with the first\n", output);
  } else if (earlier->complete) {
    say("mapless: --resume: the result in {} is complete\n", output);
  } else {
    say("mapless: --resume: {} scans are finished; they are computed again and compared with their files\n",
        earlier->finished);
  }
}

// What can be said before the recording is opened.
void require_possible(const DetectOptions& options, DetectionMethod method) {
  if (options.probability && method != DetectionMethod::voting) {
    throw ParameterError({"--probability", "method", "published", "has no evidence to derive one from",
                          "use the default method"});
  }
  if (options.semantic_kitti.empty()) return;
  require_free_predictions(options.semantic_kitti, semantic_kitti_sequence(options.recording.path));
}

// Of a rig the whole recording is labelled, each sensor as its own folder says.
void require_possible_with_rig(const DetectOptions& options) {
  const DatasetOptions& dataset = options.recording.dataset;
  const std::pair<bool, const char*> refused[] = {
      {options.resume, "--resume"},
      {options.real_time, "--realtime"},
      {options.json, "--json"},
      {!options.semantic_kitti.empty(), "--semantic-kitti"},
      {options.first > 0, "--first"},
      {options.count.has_value(), "--count"},
      {options.own_vehicle_from.has_value(), "--own-vehicle-from"},
      {options.measured.any(), "--initial-velocity, --speed, --imu"},
      {!dataset.format.empty(), "--format"},
      {!dataset.sensor.empty(), "--sensor"},
      {!dataset.labels.empty(), "--labels"}};
  for (const auto& [given, name] : refused) {
    if (given) {
      throw ParameterError(
          {name, "", "given", "not for a rig", "leave it out, or give the recording of one of its sensors"});
    }
  }
}

int detect_of_rig(const DetectOptions& options) {
  std::optional<tbb::global_control> threads;
  if (options.threads) threads.emplace(tbb::global_control::max_allowed_parallelism, *options.threads);
  require_possible_with_rig(options);
  RigRunOptions rig;
  rig.recording = options.recording.path;
  rig.output = options.output;
  rig.trajectory = options.trajectory;
  rig.odometry = options.odometry;
  rig.overwrite = options.overwrite;
  rig.probability = options.probability;
  rig.detector.detection = options.parameters.chosen();
  rig.detector.odometry = options.parameters.odometry();
  rig.profile = options.parameters.profile;
  rig.configuration = configuration_text(options.parameters);
  return detect_rig(rig);
}

int detect(const DetectOptions& options) {
  std::optional<tbb::global_control> threads;
  if (options.threads) threads.emplace(tbb::global_control::max_allowed_parallelism, *options.threads);
  const ResultFolder result(options.output);
  const FolderLock lock(options.output, std::string(kProgramName));
  result.require_free(options.overwrite || options.resume);
  const OnlineDetectorOptions detector{options.parameters.chosen(), options.parameters.odometry(),
                                       options.threads != 1};
  require_possible(options, detector.detection.method);
  const auto dataset = options.recording.open();
  const std::size_t count = selected_count(options, *dataset);
  require_time_order(*dataset, options.first, count);
  const TrajectorySource motion = options.odometry
                                      ? motion_by_odometry(*dataset, options.first)
                                      : given_motion(*dataset, options.trajectory, options.first);
  announce(*dataset, motion);
  const std::vector<MotionMeasurement> measured = measurements_of(options, *dataset, motion, count);
  if (motion.trajectory) require_coverage(*dataset, *motion.trajectory, options.first, count);
  const auto doubts = said_doubts(*dataset, motion.trajectory, {options.first, count});

  const InterruptGuard interrupt;
  RunSummary summary(*dataset, options.recording.path, motion, options.parameters.profile, options.first,
                     count);
  summary.set_recording_digest(
      recording_digest(*dataset, motion.trajectory.get(), measured, options.first, count));
  summary.set_probability(options.probability);
  summary.set_input_doubts(doubts);
  std::size_t finished_before = 0;
  if (options.resume) {
    const auto earlier = earlier_run(result, summary, configuration_text(options.parameters));
    announce(earlier, options.output);
    if (earlier && earlier->complete) return trust(earlier->doubts, doubts.size());
    if (earlier) summary.set_resumed_after(finished_before = earlier->finished);
    result.remove_partial_files();
  }
  // Called with the first finished scan: a run that fails before it writes nothing and keeps an earlier
  // result.
  const auto make_folder = [&] {
    result.create(options.overwrite || options.resume, summary.text());
    if (options.probability) result.create_probabilities();
    write_file_atomically(result.config(), configuration_text(options.parameters));
  };
  std::optional<RealTimePace> pace;
  if (options.real_time) pace = pace_of(*dataset, options.first, count);
  DetectionRun run(*dataset, motion.trajectory, result, detector, summary,
                   {options.first, count, own_vehicle_from(options, motion)}, std::move(pace), make_folder,
                   finished_before);
  for (const MotionMeasurement& one : measured) run.add_measurement(one);
  if (options.probability) run.write_probabilities();
  const bool complete = run_to_the_end(run, summary);
  for (const std::string& trouble : {run.odometry_report().trouble(), summary.input_output_trouble()}) {
    if (!trouble.empty()) say("mapless: {}\n", trouble);
  }
  const int code = report(options, summary, complete, finished_before);
  if (code != kSuccess) return code;
  if (!options.semantic_kitti.empty())
    write_semantic_kitti(*dataset, result, result.labelled_scans(), options.semantic_kitti,
                         semantic_kitti_sequence(options.recording.path));
  return trust(summary.doubts(), doubts.size());
}

// What is written beside the result.
void add_output_options(CLI::App& verb, DetectOptions& options) {
  verb.add_flag("--probability", options.probability,
                "write probability/NNNNNN.f32, too: one float32 per input point, the probability that it "
                "moves (NaN: no return, or the motion is lost)");
  verb.add_option("--semantic-kitti", options.semantic_kitti,
                  "also write the labels to sequences/NN/predictions/NNNNNN.label of this folder, as "
                  "semantic-kitti-api evaluates them (mapless export --what semantic-kitti)");
  verb.add_flag("--json", options.json, "print the summary as JSON");
}

}  // namespace

void add_detect(CLI::App& app, int& exit_code) {
  auto* verb = app.add_subcommand(
      "detect",
      "Label every point of a recording as dynamic or static, and track the moving objects: position "
      "and velocity scan by scan (objects.csv). The recording of several lidars on one vehicle (a folder "
      "with rig.yaml) gives a result per sensor");
  const auto options = std::make_shared<DetectOptions>();
  add_recording_options(*verb, options->recording);
  verb->add_option("-o,--output", options->output,
                   "folder for the result; must be new or empty, unless --overwrite is given")
      ->required();
  verb->add_flag("--overwrite", options->overwrite, "replace an earlier result in the folder");
  verb->add_flag("--resume", options->resume,
                 "go on with a run into the folder that was killed or interrupted, to the same bytes as one "
                 "run. Needs its recording, options and version, and is refused where one differs. Labels "
                 "depend on all scans before: the finished ones are computed again, at the cost of the first "
                 "time, and compared with their files, which stay. Starts with the first scan where nothing "
                 "is finished, does nothing where all is")
      ->excludes("--overwrite");
  add_trajectory_options(*verb, options->trajectory);
  verb->add_flag("--odometry", options->odometry,
                 "estimate the trajectory by lidar odometry even where the recording has one")
      ->group("Trajectory")
      ->excludes("--trajectory")
      ->excludes("--stationary");
  add_parameter_options(*verb, options->parameters);
  add_motion_measurement_options(*verb, options->measured);
  verb->add_flag("--causal", options->parameters.causal,
                 "label each scan at once, without evidence from the scan after it (forward_gap = 0)");
  verb->add_option("--first", options->first, "number of the first scan to process, from 0")
      ->check(whole_number(0))
      ->capture_default_str();
  verb->add_option("--own-vehicle-from", options->own_vehicle_from,
                   "with poses: learn the own vehicle from the scans from this number on, which are read and "
                   "not labelled before --first. Of long ago it is all that labels depend on: with 0 the "
                   "labels are those of the whole recording some hundred scans after --first (default: "
                   "--first)")
      ->check(whole_number(0));
  verb->add_option("--count", options->count, "number of scans to process (default: all from --first on)")
      ->check(whole_number(1));
  verb->add_flag(
          "--realtime", options->real_time,
          fmt::format(
              "process scans at the pace at which they were recorded, as on a robot. Reports the scans that "
              "were late, the scans dropped (the oldest, where more than {} wait), and the time from the "
              "last ray of a scan to its labels",
              RealTimePace::kQueue))
      ->excludes("--resume");
  verb->add_option(
          "--threads", options->threads,
          "number of threads for odometry and detection (default: all cores); reading and writing use one "
          "more each. The result does not depend on it")
      ->check(CLI::Range(1, 1024));
  add_output_options(*verb, *options);
  verb->callback([options, &exit_code] {
    exit_code = is_rig(options->recording.path) ? detect_of_rig(*options) : detect(*options);
  });
}

}  // namespace mapless::app
