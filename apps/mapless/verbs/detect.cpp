#include <optional>
#include <string>
#include <utility>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <tbb/global_control.h>

#include "options/option_checks.hpp"
#include "options/parameter_options.hpp"
#include "options/recording_options.hpp"
#include "run/detection_run.hpp"
#include "run/motion_source.hpp"
#include "run/run_summary.hpp"
#include "terminal/interrupt.hpp"
#include "terminal/stderr.hpp"
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
  std::string output;
  std::size_t first = 0;
  std::optional<std::size_t> count;
  std::optional<std::size_t> threads;
  bool odometry = false;
  bool real_time = false;
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

void announce(const Dataset& dataset, const MotionSource& motion) {
  say("mapless: format {}, sensor {}, {} scans\n", dataset.format(), dataset.model()->name, dataset.size());
  for (const std::string& note : dataset.notes()) say("mapless: {}\n", note);
  if (motion.estimated()) {
    say("mapless: trajectory: estimated by lidar odometry\n");
    return;
  }
  std::string line;
  for (const auto& [name, value] : motion.source().conventions) {
    line += fmt::format("{}{} {}", line.empty() ? "" : ", ", name, value);
  }
  say("mapless: trajectory: {}\n", line);
}

int report(const DetectOptions& options, const RunSummary& summary, bool complete) {
  if (!complete && summary.scans() == 0) {
    say("mapless: interrupted before the first scan was finished; nothing is written\n");
    return InterruptGuard::exit_code();
  }
  if (!complete) {
    say("mapless: interrupted after {} finished scans; they are valid, the summary says incomplete\n",
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
  MotionSource motion =
      options.odometry
          ? MotionSource::odometry(*dataset, options.first, options.parameters.odometry())
          : MotionSource(*dataset, options.trajectory, options.first, options.parameters.odometry());
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
  std::optional<RealTimePace> pace;
  if (options.real_time) pace = pace_of(*dataset, options.first, count);
  DetectionRun run(*dataset, motion, result, parameters, summary, {options.first, count},
                   options.threads != 1, std::move(pace), make_folder);
  const bool complete = run_to_the_end(run, summary);
  if (const std::string trouble = motion.trouble(); !trouble.empty()) say("mapless: {}\n", trouble);
  if (const std::string trouble = summary.input_output_trouble(); !trouble.empty())
    say("mapless: {}\n", trouble);
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
  verb->add_flag(
      "--realtime", options->real_time,
      fmt::format("play the recording at its own pace, as a robot would hear it: tells scans late, "
                  "scans dropped (of more than {} waiting, the oldest), and the time from the last "
                  "ray of a scan to its labels",
                  RealTimePace::kQueue));
  verb->add_option("--threads", options->threads,
                   "threads that detect (all cores where not given); reading and writing have one each "
                   "besides. The result is the same")
      ->check(CLI::Range(1, 1024));
  verb->add_flag("--json", options->json, "print the summary as JSON");
  verb->callback([options, &exit_code] { exit_code = detect(*options); });
}

}  // namespace mapless::app
