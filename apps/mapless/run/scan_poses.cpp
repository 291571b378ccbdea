#include "run/scan_poses.hpp"

#include <algorithm>
#include <cstdint>

namespace mapless::app {

std::vector<TimedPose> scan_poses(const Trajectory& trajectory, Time begin, Time end, int count) {
  std::vector<TimedPose> poses;
  const std::int64_t length_ns = (end - begin).nanoseconds();
  for (int i = 0; i < count; ++i) {
    const Time t = begin + Duration::from_nanoseconds(length_ns * i / count);
    if (t > trajectory.end()) break;
    if (poses.empty() || t > poses.back().time) poses.push_back({t, trajectory.at(t).T_v0});
  }
  return poses;
}

void append_poses(std::vector<TimedPose>& poses, const std::vector<TimedPose>& more) {
  if (more.empty()) return;
  while (!poses.empty() && poses.back().time >= more.front().time) poses.pop_back();
  poses.insert(poses.end(), more.begin(), more.end());
}

void append_last_pose(std::vector<TimedPose>& poses, const Trajectory& trajectory, Time end) {
  const Time last = std::min(end, trajectory.end());
  if (!poses.empty() && last > poses.back().time) poses.push_back({last, trajectory.at(last).T_v0});
}

}  // namespace mapless::app
