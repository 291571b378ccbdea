#include <mapless/simulation/scene.hpp>

namespace mapless::inline v1 {

std::vector<TimedPose> Scene::poses_in_world() const {
  std::vector<TimedPose> out = poses;
  const SE3 T_0w = T_w0.inverse();
  for (TimedPose& pose : out) pose.T_v0 = pose.T_v0 * T_0w;
  return out;
}

}  // namespace mapless
