#pragma once

#include "odometry/keypoints/thinning.hpp"

namespace mapless::inline v1 {

/// Selects the keypoints that are registered: one point per cube of the sensor frame, the first in
/// golden_order, by increasing time. While they are fewer than `min_keypoints`, the cubes are halved, at most
/// `max_halvings` times (method.md section 6).
[[nodiscard]] std::vector<ScanPoint> select_keypoints(const std::vector<ScanPoint>& points,
                                                      const OdometryParameters& parameters, int max_halvings);

}  // namespace mapless
