#include <algorithm>
#include <ctime>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <sstream>
#include <string>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <tbb/global_control.h>
#include <tbb/info.h>

#include "benchmark/benchmark_folder.hpp"
#include "benchmark/job_run.hpp"
#include "benchmark/page/page.hpp"
#include "benchmark/paper/paper_benchmark.hpp"
#include "benchmark/plan.hpp"
#include "benchmark/recording_store.hpp"
#include "benchmark/speed/speed.hpp"
#include "benchmark/speed/speed_plots.hpp"
#include "benchmark/work_pool.hpp"
#include "options/option_checks.hpp"
#include "reports/json.hpp"
#include "reports/json_text.hpp"
#include "terminal/interrupt.hpp"
#include "terminal/stderr.hpp"
#include "verbs/verbs.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/files.hpp>
#include <mapless/lidar/lidar_model.hpp>
#include <mapless/simulation/scene.hpp>

namespace mapless::app {
namespace {

namespace fs = std::filesystem;
struct BenchmarkOptions {
  PlanOptions plan;
  std::string output;
  std::string recordings;
  std::optional<std::size_t> threads;
  bool speed = false;
  bool paper = false;
  bool json = false;
};

std::size_t scans_of(const Job& job) {
  const std::size_t all = RecordingStore::scans(job.recording);
  return std::min(all, job.first_scans.value_or(all));
}

/// False where interrupted.
bool simulate_missing(const std::vector<const Job*>& jobs, const RecordingStore& store, std::size_t threads) {
  std::set<RecordingKey> keys;
  for (const Job* job : jobs) keys.insert(job->recording);
  std::vector<LongTask> tasks;
  std::size_t scans = 0;
  for (const RecordingKey& key : keys) {
    if (InterruptGuard::requested()) return false;
    if (store.has(key)) continue;
    scans += RecordingStore::scans(key);
    tasks.emplace_back([&store, key](const auto& step_done) { return store.make(key, step_done); });
  }
  if (!tasks.empty()) {
    say("mapless: simulating {} recordings ({} made before)\n", tasks.size(), keys.size() - tasks.size());
  }
  return work_side_by_side(tasks, threads, scans, "scans");
}

/// False where interrupted.
bool run_missing(const std::vector<const Job*>& jobs, const RecordingStore& store,
                 const BenchmarkFolder& folder, std::size_t threads) {
  std::vector<LongTask> tasks;
  std::size_t scans = 0;
  for (const Job* job : jobs) {
    scans += scans_of(*job);
    tasks.emplace_back([&store, &folder, job](const auto& step_done) {
      const auto result = run_job(*job, store.path(job->recording), folder, step_done);
      if (result) folder.finish(job->stem(), job->json(), *result);
      return result.has_value();
    });
  }
  return work_side_by_side(tasks, threads, scans, "scans");
}

std::string processor_name() {
  std::istringstream lines(read_whole_file("/proc/cpuinfo"));
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("model name")) return line.substr(std::min(line.size(), line.find(':') + 2));
  }
  return "unknown processor";
}

std::string utc_date() {
  const std::time_t now = std::time(nullptr);
  std::tm parts = {};
  gmtime_r(&now, &parts);
  return fmt::format("{:04}-{:02}-{:02}", parts.tm_year + 1900, parts.tm_mon + 1, parts.tm_mday);
}

// What was run where and when; the program begins benchmark.json.
Json about_this_run() {
  return {{"program", kBenchmarkName},
          {"complete", true},
          {"version", MAPLESS_VERSION},
          {"date", utc_date()},
          {"processor", processor_name()}};
}

Json figures(const std::vector<Job>& jobs, const BenchmarkOptions& options, const BenchmarkFolder& folder,
             std::size_t threads) {
  Json rows = Json::array();
  for (const Job& job : jobs) {
    rows.push_back({{"job", job.json()}, {"result", folder.finished(job.stem(), job.json()).value()}});
  }
  Json out = about_this_run();
  const Json settings = {{"threads", threads},
                         {"quick", options.plan.quick},
                         {"odometry", options.plan.odometry},
                         {"profile", options.plan.parameters.profile},
                         {"settings", options.plan.parameters.settings},
                         {"stretch_scans", stretch_scans(options.plan)},
                         {"rows", rows}};
  out.update(settings);
  return out;
}

int report_interrupt(std::size_t finished, std::size_t of) {
  say("mapless: interrupted; {} of {} runs are finished and kept; the same command continues\n", finished,
      of);
  return InterruptGuard::exit_code();
}

std::size_t threads_of(const BenchmarkOptions& options) {
  return options.threads.value_or(static_cast<std::size_t>(tbb::info::default_concurrency()));
}

void write_speed(const Json& measured, const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) {
    throw OutputError({folder.string(), "output folder", "", "cannot make it: " + error.message(),
                       "choose a folder you may write to"});
  }
  write_file_atomically(folder / "speed.json", json_text(measured));
  time_against_rays(measured).png().write_png(folder / "time_against_rays.png");
  time_against_threads(measured).png().write_png(folder / "time_against_threads.png");
}

int benchmark_speed(const BenchmarkOptions& options) {
  SpeedOptions speed;
  if (!options.plan.sensors.empty()) speed.sensors = options.plan.sensors;
  if (!options.plan.scenes.empty()) speed.scene = options.plan.scenes.front();
  speed.duration_s = options.plan.duration_s.value_or(speed.duration_s);
  if (!options.plan.seeds.empty()) speed.seed = options.plan.seeds.front();
  speed.detector = options.plan.parameters.chosen();
  speed.odometry = options.plan.parameters.odometry();
  if (options.threads || !options.output.empty()) speed.most_threads = static_cast<int>(threads_of(options));
  const InterruptGuard interrupt;
  const Json measured = measure_speed(speed);
  fmt::print("{}", options.json ? json_text(measured) : speed_text(measured));
  if (InterruptGuard::requested()) return InterruptGuard::exit_code();
  if (!options.output.empty()) write_speed(measured, options.output);
  return 0;
}

int benchmark(const BenchmarkOptions& options) {
  if (options.speed) return benchmark_speed(options);
  if (options.output.empty()) throw CLI::RequiredError("--output");
  if (options.paper) {
    return benchmark_paper({options.plan.quick, options.plan.seeds, options.plan.duration_s}, options.output,
                           threads_of(options), about_this_run());
  }
  const std::vector<Job> jobs = make_plan(options.plan);
  for (const Job& job : jobs) static_cast<void>(scans_of(job));  // throws for what is too short
  const std::size_t threads = threads_of(options);
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);

  const BenchmarkFolder folder(options.output, build_digest());
  folder.open();
  const RecordingStore store(options.recordings.empty() ? folder.recordings() : fs::path(options.recordings));
  std::vector<const Job*> missing;
  for (const Job& job : jobs) {
    if (!folder.finished(job.stem(), job.json())) missing.push_back(&job);
  }
  say("mapless: {} runs, {} of them finished before\n", jobs.size(), jobs.size() - missing.size());

  const InterruptGuard interrupt;
  if (!simulate_missing(missing, store, threads) || !run_missing(missing, store, folder, threads)) {
    const auto finished =
        static_cast<std::size_t>(std::count_if(jobs.begin(), jobs.end(), [&](const Job& job) {
          return folder.finished(job.stem(), job.json()).has_value();
        }));
    return report_interrupt(finished, jobs.size());
  }
  const Json all = figures(jobs, options, folder, threads);
  write_page(all, folder);
  write_file_atomically(folder.figures(), json_text(all));
  fmt::print("{}page: {}\nfigures: {}\n", results_text(all), folder.page().string(),
             folder.figures().string());
  return 0;
}

// The last of the verb's options: it names the others, which it excludes.
void add_paper_option(CLI::App& verb, bool& paper) {
  auto* flag = verb.add_flag(
      "--paper", paper,
      "repeat the evaluation of the paper: town1 and town2 for five minutes each (20 s with --quick), 64 x "
      "2000 rays a scan; error thresholds from 0.05 to 2 m at three levels of noise; after each stage; "
      "within a range limit; without motion compensation; without forward check; times. The published and "
      "the default method beside each other. Takes about an hour of processor time; keeps nothing but "
      "figures on disk");
  for (const char* other : {"--scenes", "--sensors", "--noise", "--faulty", "--odometry", "--speed",
                            "--profile", "--config", "--set", "--recordings"})
    flag->excludes(verb.get_option(other));
}

void add_table_options(CLI::App& verb, PlanOptions& plan) {
  verb.add_flag("--quick", plan.quick,
                "10 s of town1 with a short parameter sweep; takes less than three minutes on two cores");
  verb.add_option(
          "--scenes", plan.scenes,
          "scenes to run in place of the default table (every scene with every one of --sensors and --noise)")
      ->check(CLI::IsMember(scene_names()));
  verb.add_option("--sensors", plan.sensors,
                  fmt::format("sensors to run, of {}, or calibration files (Velodyne's YAML, Ouster's JSON, "
                              "Hesai's CSV, or a sensor.yaml)",
                              fmt::join(named_models(), ", ")));
  verb.add_option("--noise", plan.range_noises_m,
                  "standard deviations of the range noise to run [m], 0 to 1");
  verb.add_option("--faulty", plan.faulty,
                  "simulate missing returns from glass, dark paint and distant ground")
      ->check(CLI::IsMember({"on", "off"}))
      ->capture_default_str();
  verb.add_option("--seeds", plan.seeds, "seeds of the random scenes, traffic and noise")
      ->check(whole_number(0))
      ->capture_default_str();
  verb.add_option("--duration-s", plan.duration_s,
                  "duration of each recording [s], at most 600 (default: 20; 10 with --quick)")
      ->check(positive_number());
  verb.add_flag("--odometry", plan.odometry,
                "also run every recording with lidar odometry in place of the true poses, and compare");
}

}  // namespace

void add_benchmark(CLI::App& app, int& exit_code) {
  auto* verb = app.add_subcommand(
      "benchmark", "Simulate a table of scenes, detect, evaluate, and write all figures to one page");
  const auto options = std::make_shared<BenchmarkOptions>();
  verb->add_option(
      "-o,--output", options->output,
      "folder for page, plots and figures: a new one, or that of an earlier benchmark to continue");
  add_table_options(*verb, options->plan);
  auto* speed = verb->add_flag(
      "--speed", options->speed,
      "measure speed in place of accuracy: the time of each stage on one thread, and of odometry and "
      "detection together on one and two threads, beside the time of a k-d tree (build, and one "
      "query per point) in the same run. Uses the first of --scenes; --sensors also takes "
      "OS1-128x2048 and the like. With --output: writes speed.json, and plots of time against "
      "rays and against threads, up to --threads");
  verb->add_flag("--json", options->json, "print the figures of --speed as JSON")->needs(speed);
  add_parameter_options(*verb, options->plan.parameters);
  verb->add_option("--recordings", options->recordings,
                   "folder for the simulated recordings, about 30 MB per second of HDL-64E (default: "
                   "OUTPUT/recordings)");
  verb->add_option("--threads", options->threads,
                   "number of threads (default: all cores). The figures do not depend on it")
      ->check(CLI::Range(1, 1024));
  add_paper_option(*verb, options->paper);
  verb->callback([options, &exit_code] { exit_code = benchmark(*options); });
}

}  // namespace mapless::app
