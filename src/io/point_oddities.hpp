#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include <mapless/lidar/lidar_scan.hpp>

namespace mapless::inline v1 {

/// Finds scans whose points can be read and yet make no sense together: what a wrong unit, field or
/// description of the sensor makes of a recording.
class PointOddities {
 public:
  void add(const LidarScan& scan, std::size_t k);
  /// One line for each kind, naming the first scan it is found in.
  [[nodiscard]] std::vector<std::string> lines() const;

 private:
  struct Found {
    std::size_t first = 0;
    std::size_t scans = 0;
    std::string text;  // of the first
  };
  void found(const std::string& kind, std::size_t k, const std::string& text);

  std::map<std::string, Found> found_;
};

}  // namespace mapless
