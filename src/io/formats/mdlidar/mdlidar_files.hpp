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

/// Rows of vel_64_calib.csv. Throws InputError naming line and value.
[[nodiscard]] std::vector<MdlidarLaser> read_mdlidar_calibration(const std::filesystem::path& file);

/// The header. Throws InputError for one that is corrupt or has no channels or points.
[[nodiscard]] mdlidar::Header read_mdlidar_header(const std::filesystem::path& file);

/// A frame, whole. Throws InputError where it is corrupt or has not `points` points.
[[nodiscard]] mdlidar::Frame read_mdlidar_frame(const std::filesystem::path& file, std::size_t points);

/// What a frame has beside its points; poses as they stand, T_file_b or its inverse.
struct MdlidarFrameSummary {
  Time start;
  Time end;
  SE3 pose_at_start;  ///< position_p, orientation_p
  SE3 pose_at_end;
};

/// Reads a frame without building its points. Throws InputError for a corrupt one, times that do not rise, or
/// a pose that is absent or none.
[[nodiscard]] MdlidarFrameSummary read_mdlidar_summary(const std::filesystem::path& file);

}  // namespace mapless
