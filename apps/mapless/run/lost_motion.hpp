#pragma once

#include <cstddef>
#include <string>

#include <mapless/io/trajectory_file.hpp>
#include <mapless/odometry/odometry_update.hpp>

namespace mapless::app {

/// The row of poses.csv of a scan of this duration [s].
[[nodiscard]] MotionRow motion_row(std::size_t scan, const TimedPose& pose, double duration_s,
                                   const OdometryUpdate& update);

/// "finished; 3 of 60 scans are without motion: ..." with the remedy. The run
/// then ends with kNotTrusted.
[[nodiscard]] std::string motion_lost_line(std::size_t lost, std::size_t scans);

}  // namespace mapless::app
