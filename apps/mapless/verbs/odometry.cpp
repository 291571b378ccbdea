#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <tbb/global_control.h>

#include "options/motion_measurements.hpp"
#include "options/parameter_options.hpp"
#include "options/recording_options.hpp"
#include "reports/json.hpp"
#include "reports/json_text.hpp"
#include "run/earlier_run.hpp"
#include "run/folder_lock.hpp"
#include "run/given_motion.hpp"
#include "run/lost_motion.hpp"
#include "run/odometry_run.hpp"
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

namespace fs = std::filesystem;

struct OdometryOptions {
  RecordingOptions recording;
  ParameterOptions parameters;
  MotionMeasurementOptions measured;
  fs::path output;
  PoseChoice poses;
  std::optional<std::size_t> threads;
  bool overwrite = false;
  bool resume = false;
  bool json = false;
};

// The contents of summary.json.
struct OdometrySummary {
  Json input;  // recording, settings, digest
  std::vector<std::string> doubts;
  std::string trouble, stopped;
  bool complete = false;

  [[nodiscard]] Json json(const Json& run) const {
    Json out = {{"program", kOdometryProgramName},
                {"version", MAPLESS_VERSION},
                {"complete", complete},
                {"doubts", doubts}};
    out.update(input);
    out.update(run);
    out["trouble"] = trouble;
    if (!stopped.empty()) out["stopped"] = stopped;
    return out;
  }
};

Json input_json(const OdometryOptions& options, const Dataset& dataset,
                const std::vector<MotionMeasurement>& measured) {
  return {{"recording", options.recording.path},
          {"recording_digest", recording_digest(dataset, nullptr, measured, 0, dataset.size())},
          {"format", dataset.format()},
          {"sensor", dataset.model()->name},
          {"selected_scans", dataset.size()},
          {"pose_instant", options.poses.instant},
          {"poses_per_scan", options.poses.per_scan}};
}

void write_summary(const ResultFolder& result, const OdometrySummary& summary, const OdometryRun& run,
                   std::size_t finished_before) {
  if (run.scans() == 0 || run.scans() < finished_before) return;
  write_file_atomically(result.summary(), json_text(summary.json(run.json())));
}

bool run_to_the_end(OdometryRun& run, const ResultFolder& result, OdometrySummary& summary,
                    std::size_t finished_before) {
  try {
    summary.complete = run.run();
    if (!summary.complete) summary.stopped = "interrupted";
    summary.trouble = run.report().trouble();
    for (std::string& line : further_doubts(summary.doubts, run.scan_doubts()))
      summary.doubts.push_back(std::move(line));
    if (const std::string doubt = motion_doubt(run.report()); summary.complete && !doubt.empty())
      summary.doubts.push_back(doubt);
    write_summary(result, summary, run, finished_before);
    return summary.complete;
  } catch (const std::exception& error) {
    summary.stopped = error.what();
    try {
      write_summary(result, summary, run, finished_before);
    } catch (const OutputError&) {  // the first error is the one to report
    }
    throw;
  }
}

int interrupted(std::size_t scans, std::size_t finished_before) {
  if (scans == 0) {
    say("mapless: interrupted before the first pose was final; nothing is written\n");
  } else if (scans < finished_before) {
    say("mapless: interrupted before the scans finished earlier were computed again; the result is as it "
        "was\n");
  } else {
    say("mapless: interrupted; the poses of {} scans are written, summary.json says incomplete\n", scans);
  }
  return InterruptGuard::exit_code();
}

void announce(const std::optional<EarlierRun>& earlier, const fs::path& output) {
  if (!earlier) {
    say("mapless: --resume: no finished scan in {}, starts with the first\n", output.string());
  } else if (earlier->complete) {
    say("mapless: --resume: the result in {} is complete\n", output.string());
  } else {
    say("mapless: --resume: {} scans are finished; they are computed again and compared with their files\n",
        earlier->finished);
  }
}

int odometry(const OdometryOptions& options) {
  std::optional<tbb::global_control> threads;
  if (options.threads) threads.emplace(tbb::global_control::max_allowed_parallelism, *options.threads);
  const ResultFolder result(options.output);
  const FolderLock lock(options.output, std::string(kOdometryProgramName));
  result.require_free(options.overwrite || options.resume, kOdometrySummaryBegin);
  const auto dataset = options.recording.open();
  (void)motion_by_odometry(*dataset, 0);  // refuses a compensated recording
  require_time_order(*dataset, 0, dataset->size());
  const std::vector<MotionMeasurement> measured = options.measured.measurements(*dataset, 0, dataset->size());
  OdometrySummary summary{input_json(options, *dataset, measured),
                          said_doubts(*dataset, nullptr, {0, dataset->size()}), "", "", false};
  const std::size_t doubts_said = summary.doubts.size();
  std::size_t finished_before = 0;
  const std::string configuration = configuration_text(options.parameters);
  if (options.resume) {
    const auto earlier = earlier_odometry(result, summary.json(Json::object()), configuration);
    announce(earlier, options.output);
    if (earlier && earlier->complete) return earlier->doubts.empty() ? kSuccess : kNotTrusted;
    if (earlier) finished_before = earlier->finished;
    result.remove_partial_files();
  }
  const InterruptGuard interrupt;
  // Called with the first pose: a run that fails before it writes nothing and keeps an earlier result.
  const auto make_folder = [&] {
    result.create_for_odometry(options.overwrite || options.resume, json_text(summary.json(Json::object())));
    write_file_atomically(result.config(), configuration);
  };
  OdometryRun run(*dataset, result, options.parameters.odometry(), options.poses, make_folder,
                  finished_before);
  for (const MotionMeasurement& one : measured) run.add_measurement(one);
  if (!run_to_the_end(run, result, summary, finished_before))
    return interrupted(run.scans(), finished_before);
  if (!summary.trouble.empty()) say("mapless: {}\n", summary.trouble);
  for (std::size_t i = doubts_said; i < summary.doubts.size(); ++i)
    say("mapless: finished; {}\n", summary.doubts[i]);
  if (options.json) {
    fmt::print("{}", json_text(summary.json(run.json())));
  } else {
    fmt::print("{} poses at the {} of the scans in {}; {:.1f} ms a scan (median, without reading)\n",
               run.scans(), options.poses.instant, options.output.string(), run.median_ms());
  }
  return summary.doubts.empty() ? kSuccess : kNotTrusted;
}

}  // namespace

void add_odometry(CLI::App& app, int& exit_code) {
  auto* verb = app.add_subcommand("odometry", "Estimate the trajectory of the sensor from the lidar alone");
  const auto options = std::make_shared<OdometryOptions>();
  add_recording_options(*verb, options->recording);
  add_parameter_options(*verb, options->parameters);
  add_motion_measurement_options(*verb, options->measured);
  verb->add_option("-o,--output", options->output,
                   "folder for poses_kitti.txt (KITTI rows), trajectory.txt (TUM rows) and poses.csv (with "
                   "the state of the motion: good, degenerate or lost), all world from sensor, written scan "
                   "by scan; must be new or empty, unless --overwrite or --resume is given")
      ->required();
  verb->add_option("--pose-instant", options->poses.instant,
                   "the instant within each scan whose pose is written")
      ->check(CLI::IsMember({"start", "middle", "end"}))
      ->capture_default_str();
  verb->add_option(
          "--poses-per-scan", options->poses.per_scan,
          "number of poses per scan in trajectory.txt, evenly spaced from --pose-instant on; more than one "
          "keeps the motion within the scan. poses_kitti.txt always has one per scan")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  verb->add_option("--threads", options->threads,
                   "number of threads (default: all cores). The result does not depend on it")
      ->check(CLI::Range(1, 1024));
  verb->add_flag("--overwrite", options->overwrite, "replace the poses of an earlier run in the folder");
  verb->add_flag("--resume", options->resume,
                 "go on with a run into the folder that was killed or interrupted, to the same bytes as one "
                 "run, as --resume of mapless detect: the finished scans are computed again and compared")
      ->excludes("--overwrite");
  verb->add_flag("--json", options->json, "print a summary with the time per scan as JSON");
  verb->callback([options, &exit_code] { exit_code = odometry(*options); });
}

}  // namespace mapless::app
