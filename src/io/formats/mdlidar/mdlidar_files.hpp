#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <vector>

#include "io/formats/mdlidar/mdlidar_writer.hpp"
#include <mapless/core/se3.hpp>
#include <mapless/core/time.hpp>

namespace mdlidar {
class Header;
}  // namespace mdlidar

namespace mapless::inline v1 {

/// Reads the rows of vel_64_calib.csv. Throws InputError naming line and value.
[[nodiscard]] std::vector<MdlidarLaser> read_mdlidar_calibration(const std::filesystem::path& file);

/// Reads the header. Throws InputError if it is corrupt or has no channels or points.
[[nodiscard]] mdlidar::Header read_mdlidar_header(const std::filesystem::path& file);

/// Reads the points of a frame in the order of the file, without keeping them: visit(i, point i). Throws
/// InputError if the frame is corrupt or its number of points is not `points`; some may have been visited by
/// then.
void read_mdlidar_points(const std::filesystem::path& file, std::size_t points,
                         const std::function<void(std::size_t, const MdlidarPoint&)>& visit);

/// Times and poses of a frame, as they are in the file: PoseReading says what they mean.
struct MdlidarFrameSummary {
  Time start;
  Time end;
  SE3 pose_p;  ///< position_p, orientation_p
  SE3 pose;    ///< position, orientation
  std::size_t points = 0;
};

/// Throws InputError unless the frame in `file` has as many points as the header says.
void require_mdlidar_points(const std::filesystem::path& file, std::size_t points, std::size_t of_header);

/// Reads times and poses of a frame and counts its points. Throws InputError if it is corrupt, its times do
/// not increase, or a pose is missing or invalid.
[[nodiscard]] MdlidarFrameSummary read_mdlidar_summary(const std::filesystem::path& file);

}  // namespace mapless
