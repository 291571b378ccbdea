#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include <mapless/lidar/lidar_scan.hpp>

namespace mapless::inline v1 {

/// Finds scans whose points are implausible as a whole: symptoms of a wrong unit, field or sensor model.
class PointOddities {
 public:
  void add(const LidarScan& scan, std::size_t k);
  /// One line per kind of irregularity, naming its first scan.
  [[nodiscard]] std::vector<std::string> lines() const;

 private:
  struct Found {
    std::size_t first = 0;
    std::size_t scans = 0;
    std::string text;  // message of the first scan
  };
  void found(const std::string& kind, std::size_t k, const std::string& text);

  std::map<std::string, Found> found_;
};

}  // namespace mapless
