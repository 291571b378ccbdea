#pragma once

#include "odometry/thinning.hpp"

namespace mapless {

/// One point (the first in mixed_order) per cube of the sensor frame, by time. Cubes are halved up to twice
/// where they give fewer than `min_keypoints`.
[[nodiscard]] std::vector<ScanPoint> select_keypoints(const std::vector<ScanPoint>& points,
                                                      const OdometryParameters& parameters);

}  // namespace mapless
