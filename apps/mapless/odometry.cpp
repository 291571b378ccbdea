#include <chrono>
#include <ctime>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <tbb/global_control.h>

#include "json_text.hpp"
#include "motion_source.hpp"
#include "parameter_options.hpp"
#include "progress.hpp"
#include "recording_options.hpp"
#include "scan_poses.hpp"
#include "verbs.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/evaluation/quantile.hpp>
#include <mapless/io/trajectory_file.hpp>

namespace mapless::app {
namespace {

struct OdometryOptions {
  RecordingOptions recording;
  ParameterOptions parameters;
  std::filesystem::path output;
  std::string instant = "start";
  int poses_per_scan = 1;
  std::optional<std::size_t> threads;
  bool overwrite = false;
  bool json = false;
};

struct OutputFiles {
  std::filesystem::path kitti, tum;

  explicit OutputFiles(const std::filesystem::path& folder)
      : kitti(folder / "poses_kitti.txt"), tum(folder / "trajectory.txt") {}

  void require_free() const {
    for (const auto& file : {kitti, tum}) {
      if (!std::filesystem::exists(file)) continue;
      throw OutputError({file.string(), "", "", "is there already", "choose another folder, or --overwrite"});
    }
  }
};

Time instant_of(const LidarScan& scan, const std::string& instant) {
  if (instant == "start") return scan.start;
  if (instant == "end") return scan.end();
  return scan.start + Duration::from_nanoseconds((scan.end() - scan.start).nanoseconds() / 2);
}

/// What one run found.
struct Estimate {
  std::vector<TimedPose> at_instants;  ///< one a scan
  std::vector<TimedPose> rows;         ///< as many as asked for
  std::vector<double> scan_ms;         ///< odometry alone, without reading
  std::vector<double> scan_cpu_ms;     ///< the same in time of the process's threads
};

// The motion as it is known in the end.
Estimate estimate(const Dataset& dataset, const OdometryOptions& options, MotionSource& motion) {
  Progress progress("scans");
  Estimate out;
  std::vector<std::pair<Time, Duration>> scans;  // instant and length
  for (std::size_t k = 0; k < dataset.size(); ++k) {
    const auto scan = std::make_shared<const LidarScan>(dataset.read(k));
    scans.emplace_back(instant_of(*scan, options.instant), scan->end() - scan->start);
    const auto begin = std::chrono::steady_clock::now();
    const std::clock_t cpu_begin = std::clock();
    (void)motion.add(scan);
    out.scan_ms.push_back(
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count());
    out.scan_cpu_ms.push_back(1e3 * static_cast<double>(std::clock() - cpu_begin) / CLOCKS_PER_SEC);
    progress.update(k + 1, dataset.size());
  }
  progress.clear();
  const Trajectory& trajectory = motion.trajectory();
  for (const auto& [instant, length] : scans) {
    out.at_instants.push_back({instant, trajectory.at(instant).T_v0});
    append_poses(out.rows, scan_poses(trajectory, instant, instant + length, options.poses_per_scan));
  }
  if (options.poses_per_scan > 1) append_last_pose(out.rows, trajectory, trajectory.end());
  return out;
}

nlohmann::ordered_json time_json(const std::vector<double>& ms) {
  return {{"median", quantile(ms, 0.5).value_or(0)}, {"p95", quantile(ms, 0.95).value_or(0)}};
}

std::string summary_json(const OdometryOptions& options, const Estimate& found, const std::string& trouble) {
  const nlohmann::ordered_json json = {{"program", "mapless odometry"},
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
  if (!options.overwrite) files.require_free();
  const auto dataset = options.recording.open();
  MotionSource motion = MotionSource::odometry(options.parameters.odometry());
  const Estimate found = estimate(*dataset, options, motion);
  const std::string trouble = motion.trouble();
  if (!trouble.empty()) fmt::print(stderr, "mapless: {}\n", trouble);
  std::filesystem::create_directories(options.output);
  write_kitti_poses(files.kitti, found.at_instants);
  write_tum_trajectory(files.tum, found.rows);
  if (options.json) {
    fmt::print("{}", summary_json(options, found, trouble));
    return 0;
  }
  fmt::print("{} poses at the {} of the scans in {}; {:.1f} ms a scan (median, without reading)\n",
             found.at_instants.size(), options.instant, options.output.string(),
             quantile(found.scan_ms, 0.5).value_or(0));
  return 0;
}

}  // namespace

void add_odometry(CLI::App& app, int& exit_code) {
  auto* verb = app.add_subcommand("odometry", "Estimate the motion of the sensor from the lidar alone");
  const auto options = std::make_shared<OdometryOptions>();
  add_recording_options(*verb, options->recording);
  add_parameter_options(*verb, options->parameters);
  verb->add_option("-o,--output", options->output,
                   "folder for poses_kitti.txt and trajectory.txt (TUM), both world from sensor")
      ->required();
  verb->add_option("--pose-instant", options->instant, "the instant of its scan each pose is of")
      ->check(CLI::IsMember({"start", "middle", "end"}))
      ->capture_default_str();
  verb->add_option(
          "--poses-per-scan", options->poses_per_scan,
          "rows of trajectory.txt per scan, from that instant on; several keep the motion within the "
          "scan. poses_kitti.txt always has one")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  verb->add_option("--threads", options->threads,
                   "threads used (all cores where not given); the result is the same")
      ->check(CLI::Range(1, 1024));
  verb->add_flag("--overwrite", options->overwrite, "replace the poses of that folder");
  verb->add_flag("--json", options->json, "print a summary with the time per scan as JSON");
  verb->callback([options, &exit_code] { exit_code = odometry(*options); });
}

}  // namespace mapless::app
