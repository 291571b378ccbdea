#pragma once

#include <vector>

#include <Eigen/Core>

#include "run/busy_time.hpp"

namespace mapless::app {

/// Time of nanoflann to build a k-d tree of one cloud and to find the nearest of its points to every point of
/// the other.
[[nodiscard]] BusyTime yardstick(const std::vector<Eigen::Vector3d>& of,
                                 const std::vector<Eigen::Vector3d>& queries);

}  // namespace mapless::app
