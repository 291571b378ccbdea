#pragma once

#include <cstddef>
#include <string>

#include <mapless/io/trajectory_file.hpp>
#include <mapless/odometry/odometry_update.hpp>
#include <mapless/pipeline/online_detector.hpp>

namespace mapless::app {

/// The row of poses.csv of a scan of this duration [s].
[[nodiscard]] MotionRow motion_row(std::size_t scan, const TimedPose& pose, double duration_s,
                                   const OdometryUpdate& update);

/// One line with the remedy where the motion of some scans is lost, or where that of none is good; else
/// empty. The run then ends with kNotTrusted.
[[nodiscard]] std::string motion_doubt(const OdometryReport& report);

}  // namespace mapless::app
