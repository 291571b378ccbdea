#pragma once

#include "odometry/keypoints/thinning.hpp"

namespace mapless::inline v1 {

/// One point (the first in mixed_order) per cube of the sensor frame, by time. Where they give fewer than
/// `min_keypoints`, cubes are halved, up to so many times.
[[nodiscard]] std::vector<ScanPoint> select_keypoints(const std::vector<ScanPoint>& points,
                                                      const OdometryParameters& parameters, int halvings);

}  // namespace mapless
