#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "motion_source.hpp"
#include "progress.hpp"
#include "recording_options.hpp"
#include "verbs.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/trajectory_file.hpp>

namespace mapless::app {
namespace {

struct OdometryOptions {
  RecordingOptions recording;
  std::filesystem::path output;
  std::string instant = "start";
  bool overwrite = false;
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

// The motion as it is known in the end, at one instant of every scan.
std::vector<TimedPose> estimate(const Dataset& dataset, const std::string& instant, MotionSource& motion) {
  Progress progress("scans");
  std::vector<Time> instants;
  for (std::size_t k = 0; k < dataset.size(); ++k) {
    const auto scan = std::make_shared<const LidarScan>(dataset.read(k));
    instants.push_back(instant_of(*scan, instant));
    (void)motion.add(scan);
    progress.update(k + 1, dataset.size());
  }
  progress.clear();
  std::vector<TimedPose> poses;
  for (const Time t : instants) poses.push_back({t, motion.trajectory().at(t).T_v0});
  return poses;
}

int odometry(const OdometryOptions& options) {
  const OutputFiles files(options.output);
  if (!options.overwrite) files.require_free();
  const auto dataset = options.recording.open();
  MotionSource motion = MotionSource::odometry();
  const auto poses = estimate(*dataset, options.instant, motion);
  if (const std::string trouble = motion.trouble(); !trouble.empty())
    fmt::print(stderr, "mapless: {}\n", trouble);
  std::filesystem::create_directories(options.output);
  write_kitti_poses(files.kitti, poses);
  write_tum_trajectory(files.tum, poses);
  fmt::print("{} poses at the {} of the scans in {}\n", poses.size(), options.instant,
             options.output.string());
  return 0;
}

}  // namespace

void add_odometry(CLI::App& app, int& exit_code) {
  auto* verb = app.add_subcommand("odometry", "Estimate the motion of the sensor from the lidar alone");
  const auto options = std::make_shared<OdometryOptions>();
  add_recording_options(*verb, options->recording);
  verb->add_option("-o,--output", options->output,
                   "folder for poses_kitti.txt and trajectory.txt (TUM), both world from sensor")
      ->required();
  verb->add_option("--pose-instant", options->instant, "the instant of its scan each pose is of")
      ->check(CLI::IsMember({"start", "middle", "end"}))
      ->capture_default_str();
  verb->add_flag("--overwrite", options->overwrite, "replace the poses of that folder");
  verb->callback([options, &exit_code] { exit_code = odometry(*options); });
}

}  // namespace mapless::app
