#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include <mapless/lidar/lidar_scan.hpp>

namespace mapless::inline v1 {

/// Holds the scans of a run against what is said about them, one after the other, where check_recording looks
/// at a few: points against their beams, ranges and times in every third scan; whether a scan is the one
/// before it once more in each. Says only what is clearly wrong.
class ScanWatch {
 public:
  ScanWatch();
  ~ScanWatch();
  ScanWatch(const ScanWatch&) = delete;
  ScanWatch& operator=(const ScanWatch&) = delete;

  /// Scan k as it was read, after the one before it.
  void add(const LidarScan& scan, std::size_t k);
  /// "doubtful beams: scan 4 (and 2 others): ..."; empty where nothing contradicts.
  [[nodiscard]] std::vector<std::string> lines() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace mapless
