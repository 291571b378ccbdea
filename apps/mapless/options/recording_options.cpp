#include "options/recording_options.hpp"

#include <algorithm>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "options/option_checks.hpp"
#include <mapless/io/dataset.hpp>
#include <mapless/lidar/lidar_model.hpp>

namespace mapless::app {
namespace {

// An option that is one of the names, which are those of the enum's values 0, 1, 2 ...
template <class Enum>
CLI::Option* add_choice(CLI::App& verb, const std::string& flag, Enum& value,
                        const std::vector<std::string>& names, const std::string& help) {
  const auto assign = [&value, names](const std::string& text) {
    value = static_cast<Enum>(std::find(names.begin(), names.end(), text) - names.begin());
  };
  return verb.add_option_function<std::string>(flag, assign, help)
      ->check(CLI::IsMember(names))
      ->default_str(names.at(static_cast<std::size_t>(value)));
}

CLI::Option* add_path(CLI::App& verb, const std::string& flag, std::filesystem::path& path,
                      const std::string& help) {
  return verb.add_option_function<std::string>(
      flag, [&path](const std::string& text) { path = text; }, help);
}

// How the poses of `file` are to be read.
void add_reading_options(CLI::App& verb, const std::string& prefix, const std::string& group,
                         CLI::Option* file, TrajectoryRequest& request) {
  add_choice(verb, prefix + "pose-direction", request.direction, {"world_from_sensor", "sensor_from_world"},
             "which way the poses of the file transform points")
      ->group(group)
      ->needs(file);
  auto* frame = add_choice(verb, prefix + "pose-frame", request.frame, {"sensor", "camera"},
                           "what the poses of the file are of; camera needs " + prefix + "calib")
                    ->group(group)
                    ->needs(file);
  add_path(verb, prefix + "calib", request.calibration,
           "for " + prefix + "pose-frame camera: KITTI's calib.txt or calib_velo_to_cam.txt")
      ->group(group)
      ->needs(frame);
  add_choice(verb, prefix + "pose-instant", request.instant, {"start", "middle", "end"},
             "the instant of its scan each row of a file with one row per scan is of")
      ->group(group)
      ->needs(file);
  verb.add_option_function<double>(
          prefix + "max-extrapolation-s",
          [&request](double seconds) { request.max_extrapolation_s = seconds; },
          "how far beyond its first and last pose the file's trajectory is continued at "
          "constant velocity (where not given: 0 for TUM rows; for one row per scan, to the "
          "begin of the first and the end of the last scan)")
      ->group(group)
      ->check(number_between(0, 3600))
      ->needs(file);
}

}  // namespace

std::unique_ptr<Dataset> RecordingOptions::open() const { return open_dataset(path, dataset); }

void add_recording_options(CLI::App& verb, RecordingOptions& options) {
  verb.add_option("IN", options.path, "the folder of the recording")->required();
  verb.add_option("--format", options.dataset.format,
                  fmt::format("the recording's format: {} (recognised by itself where not given)",
                              fmt::join(dataset_formats(), ", ")))
      ->check(CLI::IsMember(dataset_formats()));
  verb.add_option(
      "--sensor", options.dataset.sensor,
      fmt::format("geometry of the sensor: {}, or a calibration file: Velodyne's YAML or a sensor.yaml (the "
                  "recording's own, or estimated from its points, where not given)",
                  fmt::join(named_models(), ", ")));
  add_path(verb, "--labels", options.dataset.labels, "folder of true labels, instead of the recording's own");
  add_choice(
      verb, "--own-pose-direction", options.dataset.pose_direction,
      {"world_from_sensor", "sensor_from_world"},
      "which way the poses inside an mdlidar recording transform points; its documentation does not say");
}

void add_trajectory_options(CLI::App& verb, TrajectoryRequest& request) {
  const std::string group = "Trajectory";
  auto* file =
      add_path(verb, "--trajectory", request.file,
               "poses: TUM rows (t tx ty tz qx qy qz qw) or KITTI rows (12 numbers, one row per scan); the "
               "recording's own where not given")
          ->group(group);
  verb.add_flag("--stationary", request.stationary, "the sensor does not move")->group(group)->excludes(file);
  add_reading_options(verb, "--", group, file, request);
}

void add_pose_instant_option(CLI::App& verb, PoseInstant& instant, const std::string& help) {
  add_choice(verb, "--pose-instant", instant, {"start", "middle", "end"}, help);
}

void add_reference_trajectory_options(CLI::App& verb, TrajectoryRequest& request) {
  const std::string group = "True trajectory";
  auto* file = add_path(verb, "--reference-trajectory", request.file,
                        "true poses: TUM rows or KITTI rows (one per scan); the recording's own where not "
                        "given")
                   ->group(group);
  add_reading_options(verb, "--reference-", group, file, request);
}

}  // namespace mapless::app
