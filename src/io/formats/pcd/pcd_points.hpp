#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include <mapless/core/time.hpp>

namespace mapless::inline v1 {

/// The points of a PCD file with their rings and times.
struct PcdPoints {
  std::vector<Eigen::Vector3f> positions;  ///< [m]; not finite: no return
  std::vector<std::int64_t> rings;         ///< one per point, or empty
  std::vector<std::int64_t> times_ns;      ///< one per point, or empty
  std::size_t rows = 1;                    ///< HEIGHT: more than one for an organised cloud
  bool times_are_absolute = false;         ///< since the Unix epoch, else since the start of the scan

  /// Earliest time of a usable point; nothing without times.
  [[nodiscard]] std::optional<std::int64_t> first_time_ns() const;
};

/// Reads a PCD file. Throws InputError for another format, missing x, y or z, and times that are not finite
/// or too coarse.
[[nodiscard]] PcdPoints read_pcd_points(const std::filesystem::path& file);

}  // namespace mapless
