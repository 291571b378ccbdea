#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <mapless/io/trajectory_file.hpp>
#include <mapless/pipeline/online_detector.hpp>

namespace mapless::app {

/// A run of `mapless detect` over the recording of a rig.
struct RigRunOptions {
  std::filesystem::path recording;  ///< holds rig.yaml, and a recording per sensor
  std::filesystem::path output;     ///< gets a result per sensor, in a folder of the sensor's name
  TrajectoryRequest trajectory;     ///< of the first sensor
  bool odometry = false;            ///< estimate it even where its recording has one
  bool overwrite = false;
  bool probability = false;
  OnlineDetectorOptions detector;
  std::string profile;
  std::string configuration;  ///< text of config.yaml
};

/// Labels all scans of all sensors along the motion of the first one (RigDetector), by their starts. Each
/// sensor's result is that of `mapless detect`. Returns the exit code. Throws what reading, detecting or
/// writing throws; the results are then complete up to their last scans.
[[nodiscard]] int detect_rig(const RigRunOptions& options);

}  // namespace mapless::app
