#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "lidar/recovery/model_estimation.hpp"
#include <mapless/core/se3.hpp>

namespace mapless::inline v1 {

/// A cloud whose points were taken to one instant of its turn, the sensor turning clockwise with the seam at
/// the rear (KITTI).
struct CompensatedCloud {
  RingedCloud cloud;
  /// The sensor at the middle of equal parts of the turn, from the frame of the points; not empty.
  std::vector<SE3> T_vc;
};

/// The points as lasers with these azimuth offsets [rad] measured them, one per ring: the hub angle of a
/// point is its azimuth as measured minus the offset, and the hub angle tells the instant.
[[nodiscard]] std::vector<Eigen::Vector3f> measured_points(const CompensatedCloud& compensated,
                                                           const std::vector<double>& offsets_rad);

/// The azimuth offset of every ring [rad], to a few columns, from clouds that were compensated by the
/// instants of their firings while the sensor moved: with the right offset, and with no other, the points of
/// a ring return to the grid of the hub's angle encoder. 0 for a ring that shows none. nullopt: no grid is
/// found, as without motion.
[[nodiscard]] std::optional<std::vector<double>> find_firing_offsets(
    const std::vector<CompensatedCloud>& clouds, std::size_t ring_count);

}  // namespace mapless
