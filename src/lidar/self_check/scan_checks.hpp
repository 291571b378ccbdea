#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "lidar/self_check/beam_check.hpp"
#include "lidar/self_check/scan_finding.hpp"
#include <mapless/lidar/lidar_scan.hpp>
#include <mapless/lidar/self_check.hpp>

namespace mapless::inline v1 {

/// The file of scan k of a recording.
using FileOf = std::function<std::string(std::size_t k)>;

/// What one check found in all scans: the worst finding. Wrong only where half of the scans are.
class Findings {
 public:
  explicit Findings(std::string name) : name_(std::move(name)) {}

  void add(const ScanFinding& found, std::size_t k);
  [[nodiscard]] CheckResult result(const FileOf& file_of) const;
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
  /// `given`: to tell points in the world frame; may be empty.
  void add(const LidarScan& scan, std::size_t k, const GivenPoses& given);
  [[nodiscard]] std::vector<CheckResult> results(const FileOf& file_of) const;
  /// Findings::line of each check that found something.
  [[nodiscard]] std::vector<std::string> lines() const;

 private:
  Findings ranges_{"ranges"}, beams_{"beams"}, times_{"times"}, noise_{"noise"};
};

}  // namespace mapless
