#pragma once

#include <memory>
#include <string>
#include <vector>

#include "io/self_check/pose_places.hpp"
#include <mapless/trajectory/trajectory.hpp>

namespace mapless::inline v1 {

/// What the edges of scans (select_edges) say of the poses. They tell the motion where planes do not: along
/// roads, and in tunnels.
struct EdgeFinding {
  bool agree = false;    ///< for the poses, beyond chance
  bool sure = false;     ///< so far beyond it that they outvote every registration that is slower
  std::string measured;  ///< empty where there are too few edges
  std::string problem;   ///< where they agree elsewhere, and not under the poses: what may be the mistake
};
[[nodiscard]] EdgeFinding check_edges(const std::vector<std::shared_ptr<const Place>>& places,
                                      const std::shared_ptr<const Trajectory>& given);

}  // namespace mapless
