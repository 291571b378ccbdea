#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "lidar/self_check/scan_finding.hpp"
#include <mapless/io/dataset.hpp>
#include <mapless/trajectory/trajectory.hpp>

namespace mapless::inline v1 {

/// Poses that are nearly right, against motions a little beside them: whether the static world is sharper
/// with positions a tenth longer or shorter ("pose scale"), or with poses up to 0.2 s later or earlier ("pose
/// times"). Looks at `places` pairs of scans for each: some metres apart, and a second apart where the
/// velocity changes most. Not checked where the poses hardly tell the motions apart.
[[nodiscard]] std::vector<CheckResult> check_motion(const Dataset& dataset,
                                                    const std::shared_ptr<const Trajectory>& given,
                                                    std::size_t first, std::size_t count, std::size_t places);

}  // namespace mapless
