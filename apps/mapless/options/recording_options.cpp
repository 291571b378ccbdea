#include "options/recording_options.hpp"

#include <algorithm>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "options/option_checks.hpp"
#include "options/recording_reader.hpp"
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

template <class Enum>
CLI::Option* add_choice(CLI::App& verb, const std::string& flag, std::optional<Enum>& value,
                        const std::vector<std::string>& names, const std::string& help) {
  const auto assign = [&value, names](const std::string& text) {
    value = static_cast<Enum>(std::find(names.begin(), names.end(), text) - names.begin());
  };
  return verb.add_option_function<std::string>(flag, assign, help)->check(CLI::IsMember(names));
}

CLI::Option* add_path(CLI::App& verb, const std::string& flag, std::filesystem::path& path,
                      const std::string& help) {
  return verb
      .add_option_function<std::string>(
          flag, [&path](const std::string& text) { path = text; }, help)
      ->check(not_empty());
}

// Options for reading the poses of `file`.
void add_reading_options(CLI::App& verb, const std::string& prefix, const std::string& group,
                         CLI::Option* file, TrajectoryRequest& request) {
  add_choice(verb, prefix + "pose-direction", request.direction, {"world_from_sensor", "sensor_from_world"},
             "direction of the poses in the file: which frame they map from and to")
      ->group(group)
      ->needs(file);
  auto* frame = add_choice(verb, prefix + "pose-frame", request.frame, {"sensor", "camera"},
                           "the frame whose poses the file holds; camera needs " + prefix + "calib")
                    ->group(group)
                    ->needs(file);
  add_path(verb, prefix + "calib", request.calibration,
           "camera calibration, needed with " + prefix +
               "pose-frame camera: KITTI's calib.txt or "
               "calib_velo_to_cam.txt")
      ->group(group)
      ->needs(frame);
  add_choice(verb, prefix + "pose-instant", request.instant, {"start", "middle", "end"},
             "for a file with one row per scan: the instant within the scan that each pose is at")
      ->group(group)
      ->needs(file);
  verb.add_option_function<double>(
          prefix + "max-extrapolation-s",
          [&request](double seconds) { request.max_extrapolation_s = seconds; },
          "time by which the trajectory is extrapolated beyond its first and last pose, at constant velocity "
          "[s] "
          "(default: 0 for TUM rows; for one row per scan, up to the start of the first and the end of the "
          "last scan)")
      ->group(group)
      ->check(number_between(0, 3600))
      ->needs(file);
}

}  // namespace

std::unique_ptr<Dataset> RecordingOptions::open() const {
  if (recording_reader().open) {
    if (auto opened = recording_reader().open(path, dataset, of_reader)) return opened;
  }
  return open_dataset(path, dataset);
}

void add_recording_options(CLI::App& verb, RecordingOptions& options) {
  std::vector<std::string> formats = dataset_formats();
  const RecordingReader& reader = recording_reader();
  formats.insert(formats.end(), reader.formats.begin(), reader.formats.end());
  verb.add_option("IN", options.path,
                  reader.formats.empty() ? "folder of the recording" : "file or folder of the recording")
      ->required();
  verb.add_option("--format", options.dataset.format,
                  fmt::format("format of the recording: {} (default: recognised from the files)",
                              fmt::join(formats, ", ")))
      ->check(CLI::IsMember(formats));
  for (const RecordingReader::Option& option : reader.options) {
    verb.add_option_function<std::string>(
        option.flag,
        [&options, flag = option.flag](const std::string& text) { options.of_reader[flag] = text; },
        option.help);
  }
  verb.add_option(
          "--sensor", options.dataset.sensor,
          fmt::format("sensor model: {}, or a calibration file (Velodyne's YAML, Ouster's JSON, Hesai's "
                      "CSV, or a sensor.yaml). Default: the recording's own, else estimated from its "
                      "points",
                      fmt::join(named_models(), ", ")))
      ->check(not_empty());
  add_path(verb, "--labels", options.dataset.labels,
           "folder of the true labels (default: the recording's own)");
  add_choice(verb, "--own-pose-direction", options.dataset.pose_direction,
             {"world_from_sensor", "sensor_from_world"},
             "direction of the poses in an mdlidar recording (default: that under which static points move "
             "less between scans)");
  add_choice(verb, "--own-pose-instant", options.dataset.pose_instant, {"end", "start"},
             "instant within its frame of `position` in an mdlidar recording; position_p is the pose at the "
             "start of the frame with end, and an earlier one with start (default: that under which static "
             "points move less between scans)");
}

void add_labels_option(CLI::App& verb, std::string& result) {
  verb.add_option(
      "OUT", result,
      "result of mapless detect, or a folder with labels/NNNNNN.label. Default: the true labels of "
      "the recording");
}

void add_trajectory_options(CLI::App& verb, TrajectoryRequest& request) {
  const std::string group = "Trajectory";
  auto* file =
      add_path(
          verb, "--trajectory", request.file,
          "file of poses: TUM rows (t tx ty tz qx qy qz qw) or KITTI rows (12 numbers, one row per scan). "
          "Default: the recording's own, else lidar odometry estimates them")
          ->group(group);
  verb.add_flag("--stationary", request.stationary, "the sensor stood still for the whole recording")
      ->group(group)
      ->excludes(file);
  add_reading_options(verb, "--", group, file, request);
}

void add_pose_instant_option(CLI::App& verb, PoseInstant& instant, const std::string& help) {
  add_choice(verb, "--pose-instant", instant, {"start", "middle", "end"}, help);
}

void add_reference_trajectory_options(CLI::App& verb, TrajectoryRequest& request) {
  const std::string group = "True trajectory";
  auto* file =
      add_path(verb, "--reference-trajectory", request.file,
               "file of the true poses: TUM rows or KITTI rows (one per scan). Default: the recording's "
               "own")
          ->group(group);
  add_reading_options(verb, "--reference-", group, file, request);
}

}  // namespace mapless::app
