#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "lidar/self_check/scan_finding.hpp"
#include <mapless/io/dataset.hpp>
#include <mapless/trajectory/trajectory.hpp>

namespace mapless::inline v1 {

/// Poses against the scans: how sharp the static world is under them, between two scans half a second apart,
/// beside what a short registration of these scans finds. Where they are not sharp, the usual mistakes are
/// tried. Looks at `places` (numbers of scans), and where the poses jump.
[[nodiscard]] CheckResult check_poses(const Dataset& dataset, const std::shared_ptr<const Trajectory>& given,
                                      std::size_t first, std::size_t count,
                                      const std::vector<std::size_t>& places);

}  // namespace mapless
