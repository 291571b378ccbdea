#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include <mapless/detection/parameters.hpp>
#include <mapless/odometry/parameters.hpp>

namespace mapless::app {

struct SpeedOptions {
  std::vector<std::string> sensors = {"HDL-64E-S2"};
  std::string scene = "town1";
  double duration_s = 10;
  std::uint64_t seed = 1;
  DetectorParameters detector;
  OdometryParameters odometry;
  int most_threads = 2;
};

/// How long detection (true poses), following its objects, odometry, and the pipeline of odometry and
/// detection take on one thread, and that pipeline on two (SpeedPipeline), scan by scan of a scene simulated
/// in memory, once the detector has all the scans it asks; and, in the same run, the yardstick: the time
/// nanoflann takes to build a k-d tree of one compensated scan and to find the nearest of its points to every
/// point of another. One entry per sensor (sensor_of): sensor, scans, rays, rows of name, median_ms, p95_ms,
/// p99_ms, ns_per_ray, share_of_detection (of the median), yardsticks (the same), and the median of the
/// pipeline on up to `most_threads` threads, one after the other and side by side. Throws ParameterError
/// where the scene is too short. Stops early, with what there is, where interrupted.
[[nodiscard]] nlohmann::ordered_json measure_speed(const SpeedOptions& options);

/// The same as a table.
[[nodiscard]] std::string speed_text(const nlohmann::ordered_json& speed);

}  // namespace mapless::app
