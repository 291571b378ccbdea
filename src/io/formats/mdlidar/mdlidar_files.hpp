#pragma once

#include <filesystem>
#include <vector>

#include "io/formats/mdlidar/mdlidar_writer.hpp"
#include <mapless/core/se3.hpp>
#include <mapless/core/time.hpp>

namespace mdlidar {
class Frame;
class Header;
}  // namespace mdlidar

namespace mapless::inline v1 {

/// Reads the rows of vel_64_calib.csv. Throws InputError naming line and value.
[[nodiscard]] std::vector<MdlidarLaser> read_mdlidar_calibration(const std::filesystem::path& file);

/// Reads the header. Throws InputError if it is corrupt or has no channels or points.
[[nodiscard]] mdlidar::Header read_mdlidar_header(const std::filesystem::path& file);

/// Reads a complete frame. Throws InputError if it is corrupt or its number of points is not `points`.
[[nodiscard]] mdlidar::Frame read_mdlidar_frame(const std::filesystem::path& file, std::size_t points);

/// Times and poses of a frame. The poses are those of the file, T_0v or T_v0
/// (DatasetOptions::pose_direction).
struct MdlidarFrameSummary {
  Time start;
  Time end;
  SE3 pose_at_start;  ///< position_p, orientation_p
  SE3 pose_at_end;
};

/// Reads times and poses of a frame, without its points. Throws InputError if it is corrupt, its times do not
/// increase, or a pose is missing or invalid.
[[nodiscard]] MdlidarFrameSummary read_mdlidar_summary(const std::filesystem::path& file);

}  // namespace mapless
