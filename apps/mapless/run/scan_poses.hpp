#pragma once

#include <vector>

#include <mapless/trajectory/trajectory.hpp>

namespace mapless::app {

/// So many poses a scan hold the motion within it: read back at constant velocity between them, a turn that
/// changes by 5 rad/s^2 is wrong by less than 0.1 mrad.
inline constexpr int kPosesPerScan = 10;

/// `count` poses at equal steps from `begin` on, the last one step before `end`; none beyond the trajectory's
/// end.
[[nodiscard]] std::vector<TimedPose> scan_poses(const Trajectory& trajectory, Time begin, Time end,
                                                int count);

/// Appends poses. Those there already that are not before the first of them (scans that overlap) give way.
void append_poses(std::vector<TimedPose>& poses, const std::vector<TimedPose>& more);

/// Appends the pose at `end`, where it comes after the last one and the trajectory has it.
void append_last_pose(std::vector<TimedPose>& poses, const Trajectory& trajectory, Time end);

}  // namespace mapless::app
