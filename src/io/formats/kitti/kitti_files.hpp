#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <Eigen/Core>

#include <mapless/core/time.hpp>

namespace mapless::inline v1 {

/// Points of a KITTI velodyne file: rows of float32 x, y, z [m], reflectance, little-endian. Throws
/// InputError for a file that is empty or not of whole rows.
[[nodiscard]] std::vector<Eigen::Vector3f> read_kitti_cloud(const std::filesystem::path& file);

/// "2011-09-26 13:04:32.335337762" to the nanosecond, taken as UTC. Throws InputError naming `where`.
[[nodiscard]] Time parse_date_time(const std::string& text, const std::string& where);

}  // namespace mapless
