#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include <mapless/core/time.hpp>

namespace mapless::inline v1 {

/// The points of a PCD scan with what it says of each.
struct PcdPoints {
  std::vector<Eigen::Vector3f> positions;  ///< [m]; not finite: no return
  std::vector<std::int64_t> rings;         ///< one a point, or none
  std::vector<std::int64_t> times_ns;      ///< one a point, or none
  std::size_t rows = 1;                    ///< HEIGHT: more than one where the cloud is organised
  bool times_are_absolute = false;         ///< since the epoch, not since the scan's start

  /// The earliest time of a usable point.
  [[nodiscard]] std::optional<std::int64_t> first_time_ns() const;
};

/// Throws InputError for a file that is no PCD, has no x, y and z, or times that are not finite or too
/// coarse.
[[nodiscard]] PcdPoints read_pcd_points(const std::filesystem::path& file);

}  // namespace mapless
