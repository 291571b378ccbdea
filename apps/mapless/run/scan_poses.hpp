#pragma once

#include <vector>

#include <mapless/trajectory/trajectory.hpp>

namespace mapless::app {

/// Poses written per scan. Read back at constant velocity between them, a turn that accelerates at 5 rad/s^2
/// is wrong by 5 (0.01 s)^2 / 8 = 0.06 mrad at most (scan of 0.1 s).
inline constexpr int kPosesPerScan = 10;

/// `count` poses at equal steps from `begin`, the last one step before `end`; poses beyond the end of the
/// trajectory are left out.
[[nodiscard]] std::vector<TimedPose> scan_poses(const Trajectory& trajectory, Time begin, Time end,
                                                int count);

/// Appends `more`; first removes poses that are not before the first of them (scans that overlap).
void append_poses(std::vector<TimedPose>& poses, const std::vector<TimedPose>& more);

/// Appends the pose at `end`, or at the end of the trajectory if that is earlier; nothing if `poses` reach
/// it.
void append_last_pose(std::vector<TimedPose>& poses, const Trajectory& trajectory, Time end);

}  // namespace mapless::app
