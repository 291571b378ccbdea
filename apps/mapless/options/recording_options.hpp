#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>

#include <CLI/App.hpp>

#include <mapless/io/dataset.hpp>
#include <mapless/io/trajectory_file.hpp>

namespace mapless::app {

/// The recording that a verb reads, and how it is to be read.
struct RecordingOptions {
  std::string path;
  DatasetOptions dataset;

  [[nodiscard]] std::unique_ptr<Dataset> open() const;
};

/// Adds IN, --format, --sensor, --labels, --own-pose-direction, --own-pose-instant.
void add_recording_options(CLI::App& verb, RecordingOptions& options);

/// Adds --trajectory, --stationary and how a trajectory file is to be read.
void add_trajectory_options(CLI::App& verb, TrajectoryRequest& request);

/// Adds --pose-instant.
void add_pose_instant_option(CLI::App& verb, PoseInstant& instant, const std::string& help);

/// Adds --reference-trajectory and how that file is to be read: --reference-pose-direction and so on.
void add_reference_trajectory_options(CLI::App& verb, TrajectoryRequest& request);

}  // namespace mapless::app
