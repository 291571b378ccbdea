#pragma once

#include <cstddef>
#include <string_view>

#include <mapless/io/trajectory_file.hpp>

namespace mapless::app {

/// TrajectorySource::conventions, "source", of a motion that lidar odometry estimates.
inline constexpr std::string_view kEstimatedMotion = "estimated by lidar odometry";

/// The trajectory a run is given: the one requested, else the recording's own. Where there is neither, and
/// scan `first` is not motion-compensated, `trajectory` is null: lidar odometry estimates it. Throws what
/// open_trajectory throws.
[[nodiscard]] TrajectorySource given_motion(const Dataset& dataset, const TrajectoryRequest& request,
                                            std::size_t first);

/// No trajectory: lidar odometry estimates it, whatever the recording brings. Throws InputError where scan
/// `first` is motion-compensated.
[[nodiscard]] TrajectorySource motion_by_odometry(const Dataset& dataset, std::size_t first);

}  // namespace mapless::app
