#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include <Eigen/Core>

#include <mapless/core/time.hpp>

namespace mapless::inline v1 {

/// Files of `folder` named NUMBER.extension, by number. Others are ignored. Throws InputError for a number
/// that occurs twice, or a folder that cannot be read.
[[nodiscard]] std::map<int, std::filesystem::path> numbered_files(const std::filesystem::path& folder,
                                                                  const std::string& extension);

/// Points of a KITTI velodyne file: rows of float32 x, y, z [m], reflectance, little-endian. Throws
/// InputError for a file that is empty or not of whole rows.
[[nodiscard]] std::vector<Eigen::Vector3f> read_kitti_cloud(const std::filesystem::path& file);

/// Lines of a text file without their ends; empty lines at the end are dropped. Throws InputError.
[[nodiscard]] std::vector<std::string> read_lines(const std::filesystem::path& file);

/// "2011-09-26 13:04:32.335337762" to the nanosecond, taken as UTC. Throws InputError naming `where`.
[[nodiscard]] Time parse_date_time(const std::string& text, const std::string& where);

/// "177 to 180, 190": runs of consecutive numbers missing between the first and the last key.
[[nodiscard]] std::string missing_numbers(const std::map<int, std::filesystem::path>& files);

}  // namespace mapless
