#pragma once

#include <mapless/core/errors.hpp>
#include <mapless/live/live_options.hpp>

namespace mapless::inline v1 {

/// Throws ParameterError where world_frame is empty, or the same as base_frame.
inline void require_frames(const LiveOptions& options) {
  if (!options.world_frame.empty() && options.world_frame != options.base_frame) return;
  throw ParameterError({"LiveDetector", "world_frame", options.world_frame,
                        "is empty, or base_frame, which moves in it", "name a frame, such as odom"});
}

}  // namespace mapless
