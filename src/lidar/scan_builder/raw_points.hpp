#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include <mapless/core/time.hpp>
#include <mapless/lidar/lidar_scan.hpp>

namespace mapless::inline v1 {

/// PointFields in one type and unit each, checked.
struct RawPoints {
  std::vector<Eigen::Vector3f> positions;     ///< [m]; not usable (is_usable): no return
  std::vector<std::int64_t> rings;            ///< one per point, or none
  std::vector<std::int64_t> times_ns;         ///< one per point, or none; 0 for points without a return
  std::size_t rows = 1;                       ///< more than one where the cloud is organised
  bool times_are_absolute = false;            ///< since the epoch, not since the stamp
  std::optional<std::int64_t> first_time_ns;  ///< the earliest of a usable point; none without times
};

/// Throws InputError naming `source` for fields of different lengths, without x, y or z, and for rings and
/// times that are none.
[[nodiscard]] RawPoints read_points(const PointFields& fields, const std::string& source);

}  // namespace mapless
