#pragma once

#include <map>
#include <memory>
#include <string>

#include <CLI/App.hpp>

#include <mapless/io/dataset.hpp>
#include <mapless/io/trajectory_file.hpp>

namespace mapless::app {

/// The recording that a verb reads, and how it is to be read.
struct RecordingOptions {
  std::string path;
  DatasetOptions dataset;
  std::map<std::string, std::string> of_reader;  ///< options of RecordingReader that were given, by flag

  [[nodiscard]] std::unique_ptr<Dataset> open() const;
};

/// Adds IN, --format, --sensor, --labels, --own-pose-direction, --own-pose-instant, and the options of
/// recording_reader().
void add_recording_options(CLI::App& verb, RecordingOptions& options);

/// Adds OUT, a result of mapless detect for verbs that also take the true labels of the recording.
void add_labels_option(CLI::App& verb, std::string& result);

/// Adds --trajectory, --stationary and how a trajectory file is to be read.
void add_trajectory_options(CLI::App& verb, TrajectoryRequest& request);

/// Adds --pose-instant.
void add_pose_instant_option(CLI::App& verb, PoseInstant& instant, const std::string& help);

/// Adds --reference-trajectory and how that file is to be read: --reference-pose-direction and so on.
void add_reference_trajectory_options(CLI::App& verb, TrajectoryRequest& request);

}  // namespace mapless::app
