#pragma once

#include "odometry/keypoints/thinning.hpp"

namespace mapless::inline v1 {

/// Selects the edges of a scan, by increasing time: returns beside which, in the same row and the next
/// column, a ray passed on beyond the plane through the return, to a surface farther by 0.5 m and 5 % or to
/// nothing. They lie on the outlines of poles, trees, vehicles and buildings. Outlines fix the motion along
/// roads and walls, where the planes of a sensor of few lasers leave it open, and are the same points of a
/// static object in scan after scan.
[[nodiscard]] std::vector<ScanPoint> select_edges(const LidarScan& scan,
                                                  const OdometryParameters& parameters);

}  // namespace mapless
