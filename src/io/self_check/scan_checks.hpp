#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "io/self_check/scan_finding.hpp"
#include <mapless/io/dataset.hpp>
#include <mapless/lidar/lidar_scan.hpp>
#include <mapless/trajectory/trajectory.hpp>

namespace mapless::inline v1 {

/// What one check found in all scans: the worst finding. Wrong only where half of the scans are.
class Findings {
 public:
  explicit Findings(std::string name) : name_(std::move(name)) {}

  void add(const ScanFinding& found, std::size_t k);
  [[nodiscard]] CheckResult result(const Dataset& dataset) const;
  /// "scan 4 (and 1 others): ...", empty where nothing contradicts.
  [[nodiscard]] std::string line() const;

 private:
  std::string name_;
  ScanFinding worst_;
  std::size_t worst_scan_ = 0, checked_ = 0, wrong_ = 0;
  std::vector<std::size_t> bad_;
};

/// The checks of single scans: ranges, beams, times of the points, noise.
class ScanChecks {
 public:
  /// `given`: the poses, to tell points in the world frame; may be null.
  void add(const LidarScan& scan, std::size_t k, const Trajectory* given);
  [[nodiscard]] std::vector<CheckResult> results(const Dataset& dataset) const;
  /// Findings::line of each check that found something.
  [[nodiscard]] std::vector<std::string> lines() const;

 private:
  Findings ranges_{"ranges"}, beams_{"beams"}, times_{"times"}, noise_{"noise"};
};

}  // namespace mapless
