#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <tbb/global_control.h>
#include <unistd.h>

#include "options/motion_measurements.hpp"
#include "options/parameter_options.hpp"
#include "options/recording_options.hpp"
#include "reports/json.hpp"
#include "reports/json_text.hpp"
#include "run/folder_lock.hpp"
#include "run/given_motion.hpp"
#include "run/lost_motion.hpp"
#include "run/scan_poses.hpp"
#include "terminal/exit_codes.hpp"
#include "terminal/interrupt.hpp"
#include "terminal/progress.hpp"
#include "terminal/stderr.hpp"
#include "trust/input_check.hpp"
#include "verbs/verbs.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/evaluation/trajectory_evaluation.hpp>
#include <mapless/io/result_folder.hpp>
#include <mapless/io/trajectory_file.hpp>
#include <mapless/odometry/lidar_odometry.hpp>
#include <mapless/pipeline/online_detector.hpp>

namespace mapless::app {
namespace {

namespace fs = std::filesystem;

struct OdometryOptions {
  RecordingOptions recording;
  ParameterOptions parameters;
  MotionMeasurementOptions measured;
  fs::path output;
  std::string instant = "start";
  int poses_per_scan = 1;
  std::optional<std::size_t> threads;
  bool overwrite = false;
  bool json = false;
};

class OutputFiles {
 public:
  explicit OutputFiles(fs::path folder)
      : folder_(std::move(folder)),
        kitti_(folder_ / "poses_kitti.txt"),
        tum_(folder_ / "trajectory.txt"),
        table_(folder_ / "poses.csv") {}

  // Checked before the run, which may take hours.
  void require_free(bool overwrite) const {
    require_writable();
    if (overwrite) return require_own();
    for (const fs::path& file : {kitti_, tum_, table_}) {
      if (fs::exists(file)) refuse(file, "exists already", "choose another folder, or give --overwrite");
    }
  }
  void write(const std::vector<TimedPose>& at_instants, const std::vector<TimedPose>& rows,
             const std::vector<MotionRow>& motions) const {
    std::error_code error;
    fs::create_directories(folder_, error);
    if (error) {
      throw_write_error({folder_.string(), "", "", "cannot be created: " + error.message(),
                         "choose a folder you may write to"},
                        error);
    }
    write_kitti_poses(kitti_, at_instants);
    write_tum_trajectory(tum_, rows);
    write_motion_table(table_, motions);
  }

 private:
  [[noreturn]] static void refuse(const fs::path& path, const std::string& problem,
                                  const std::string& remedy) {
    throw OutputError({path.string(), "", "", problem, remedy});
  }

  // A trajectory.txt without poses_kitti.txt belongs to a recording, one with a summary to a detection.
  void require_own() const {
    const bool alone = fs::exists(tum_) && !fs::exists(kitti_);
    if (!alone && !fs::exists(ResultFolder(folder_).summary())) return;
    refuse(tum_, "was not written by mapless odometry, and is not overwritten", "choose another folder");
  }

  // For a folder that does not exist yet: its nearest parent that does.
  void require_writable() const {
    fs::path nearest = fs::absolute(folder_);
    while (!fs::exists(nearest) && nearest.has_relative_path()) nearest = nearest.parent_path();
    if (!fs::is_directory(nearest)) refuse(nearest, "is not a folder", "choose another folder");
    if (access(nearest.c_str(), W_OK | X_OK) == 0) return;
    refuse(nearest, std::string("cannot be written into: ") + std::strerror(errno),
           "choose a folder you may write to");
  }

  fs::path folder_, kitti_, tum_, table_;
};

Time instant_of(const LidarScan& scan, const std::string& instant) {
  if (instant == "start") return scan.start;
  if (instant == "end") return scan.end();
  return scan.start + Duration::from_nanoseconds((scan.end() - scan.start).nanoseconds() / 2);
}

/// The motion over a recording.
struct Estimate {
  std::vector<TimedPose> at_instants;  ///< one per scan
  std::vector<TimedPose> rows;         ///< OdometryOptions::poses_per_scan per scan
  std::vector<MotionRow> motions;      ///< one per scan
  std::vector<double> scan_ms;         ///< odometry alone, without reading
  std::vector<double> scan_cpu_ms;     ///< the same in processor time of all threads of the process
  OdometryReport report;
};

// The trajectory as it is after the last scan; nothing where interrupted.
std::optional<Estimate> estimate(const Dataset& dataset, const OdometryOptions& options) {
  LidarOdometry lidar_odometry(options.parameters.odometry());
  for (const MotionMeasurement& one : options.measured.measurements(dataset, 0, dataset.size()))
    lidar_odometry.add_measurement(one);
  Progress progress("scans");
  Estimate out;
  std::vector<std::pair<Time, Duration>> scans;  // instant and length
  std::vector<OdometryUpdate> updates;
  for (std::size_t k = 0; k < dataset.size(); ++k) {
    if (InterruptGuard::requested()) return std::nullopt;
    const auto scan = std::make_shared<const LidarScan>(dataset.read(k));
    scans.emplace_back(instant_of(*scan, options.instant), scan->end() - scan->start);
    const auto begin = std::chrono::steady_clock::now();
    const std::clock_t cpu_begin = std::clock();
    OdometryUpdate update = lidar_odometry.process(scan);
    out.scan_ms.push_back(
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count());
    out.scan_cpu_ms.push_back(1e3 * static_cast<double>(std::clock() - cpu_begin) / CLOCKS_PER_SEC);
    out.report.add(*scan, update);
    update.knots.clear();  // the trajectory has them
    updates.push_back(std::move(update));
    // The states of the first scans are known with the scan that decides their motion.
    const std::size_t decided = std::min(updates.back().decided_scans, updates.size());
    for (std::size_t i = updates.size() - decided; i < updates.size(); ++i)
      updates[i].state = updates.back().state;
    progress.update(k + 1, dataset.size());
  }
  progress.clear();
  const Trajectory& trajectory = lidar_odometry.trajectory();
  for (std::size_t k = 0; k < scans.size(); ++k) {
    const auto& [instant, length] = scans[k];
    out.motions.push_back(
        motion_row(k, {instant, trajectory.at(instant).T_v0}, length.seconds(), updates[k]));
    out.at_instants.push_back({instant, trajectory.at(instant).T_v0});
    append_poses(out.rows, scan_poses(trajectory, instant, instant + length, options.poses_per_scan));
  }
  if (options.poses_per_scan > 1) append_last_pose(out.rows, trajectory, trajectory.end());
  return out;
}

Json time_json(const std::vector<double>& ms) {
  return {{"median", quantile(ms, 0.5).value_or(0)}, {"p95", quantile(ms, 0.95).value_or(0)}};
}

std::string summary_json(const OdometryOptions& options, const Estimate& found, const std::string& trouble) {
  const Json json = {{"program", "mapless odometry"},
                     {"recording", options.recording.path},
                     {"scans", found.at_instants.size()},
                     {"pose_instant", options.instant},
                     {"poses", found.rows.size()},
                     {"scan_ms", time_json(found.scan_ms)},
                     {"scan_cpu_ms", time_json(found.scan_cpu_ms)},
                     {"trouble", trouble}};
  return json_text(json);
}

int odometry(const OdometryOptions& options) {
  std::optional<tbb::global_control> threads;
  if (options.threads) threads.emplace(tbb::global_control::max_allowed_parallelism, *options.threads);
  const OutputFiles files(options.output);
  const FolderLock lock(options.output, "mapless odometry");
  files.require_free(options.overwrite);
  const auto dataset = options.recording.open();
  (void)motion_by_odometry(*dataset, 0);  // refuses a compensated recording
  const bool doubtful = !said_doubts(*dataset, nullptr, {0, dataset->size()}).empty();
  const InterruptGuard interrupt;
  const std::optional<Estimate> done = estimate(*dataset, options);
  if (!done) {
    say("mapless: interrupted; nothing is written\n");
    return InterruptGuard::exit_code();
  }
  const Estimate& found = *done;
  const std::string trouble = found.report.trouble();
  if (!trouble.empty()) say("mapless: {}\n", trouble);
  files.write(found.at_instants, found.rows, found.motions);
  const std::string doubt = motion_doubt(found.report);
  if (!doubt.empty()) say("mapless: finished; {}\n", doubt);
  const int code = !doubt.empty() || doubtful ? kNotTrusted : kSuccess;
  if (options.json) {
    fmt::print("{}", summary_json(options, found, trouble));
    return code;
  }
  fmt::print("{} poses at the {} of the scans in {}; {:.1f} ms a scan (median, without reading)\n",
             found.at_instants.size(), options.instant, options.output.string(),
             quantile(found.scan_ms, 0.5).value_or(0));
  return code;
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
                   "the state of "
                   "the motion: good, degenerate or lost), all world from sensor")
      ->required();
  verb->add_option("--pose-instant", options->instant, "the instant within each scan whose pose is written")
      ->check(CLI::IsMember({"start", "middle", "end"}))
      ->capture_default_str();
  verb->add_option(
          "--poses-per-scan", options->poses_per_scan,
          "number of poses per scan in trajectory.txt, evenly spaced from --pose-instant on; more than one "
          "keeps the motion within the scan. poses_kitti.txt always has one per scan")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  verb->add_option("--threads", options->threads,
                   "number of threads (default: all cores). The result does not depend on it")
      ->check(CLI::Range(1, 1024));
  verb->add_flag("--overwrite", options->overwrite, "replace the poses of an earlier run in the folder");
  verb->add_flag("--json", options->json, "print a summary with the time per scan as JSON");
  verb->callback([options, &exit_code] { exit_code = odometry(*options); });
}

}  // namespace mapless::app
