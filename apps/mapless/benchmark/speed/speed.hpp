#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "reports/json.hpp"
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

/// Measures, scan by scan of a scene simulated in memory: detection along the true trajectory and its stages,
/// odometry, and an OnlineDetector, each on one thread; an OnlineDetector on two threads; and the yardstick,
/// the time nanoflann takes to build a k-d tree of one compensated scan and to find the nearest neighbour of
/// every point of another. Counts scans once the detector has all its reference scans. One entry per sensor
/// (speed_sensor): sensor, scans, rays, rows of name, median_ms, p95_ms, p99_ms, ns_per_ray,
/// share_of_detection (of the median), yardsticks (the same), and the median of the OnlineDetector on up to
/// `most_threads` threads, with and without side_by_side. Throws ParameterError where the scene is too short.
/// Where interrupted, returns the figures so far.
[[nodiscard]] Json measure_speed(const SpeedOptions& options);

/// The same as a table.
[[nodiscard]] std::string speed_text(const Json& speed);

}  // namespace mapless::app
