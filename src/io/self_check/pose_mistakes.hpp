#pragma once

#include <memory>
#include <string>
#include <vector>

#include "io/self_check/pose_pair.hpp"
#include <mapless/trajectory/trajectory.hpp>

namespace mapless::inline v1 {

/// The motion that `given` says.
[[nodiscard]] Motion motion_of(const std::shared_ptr<const Trajectory>& given);

/// Said where no usual mistake explains the poses.
inline constexpr const char* kOtherMistake = "poses of another recording, of another frame or clock?";
/// A usual mistake: what it is in words, and the motion without it.
struct PoseMistake {
  std::string text;
  Motion motion;
};
[[nodiscard]] std::vector<PoseMistake> pose_mistakes(const std::shared_ptr<const Trajectory>& given);

}  // namespace mapless
