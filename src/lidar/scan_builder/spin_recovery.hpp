#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include <mapless/lidar/lidar_model.hpp>

namespace mapless::inline v1 {

/// The usable points of a scan by increasing atan2(y, x), with ring and, if recorded, time.
struct TimedCloud {
  std::vector<Eigen::Vector3f> points;
  std::vector<std::int32_t> rings;  ///< negative: not used
  std::vector<std::int64_t> times_ns;
};

/// Rate of rotation [Hz], counter-clockwise positive: median of azimuth step over time step of the points of
/// each ring, over steps of at least 0.1 rad. nullopt without enough steps.
[[nodiscard]] std::optional<double> spin_rate_hz(const std::vector<TimedCloud>& clouds);

/// Completes azimuth offsets that are known modulo a column. Points measured at one instant share the hub
/// angle, so the difference of their azimuths is the difference of their lasers' offsets, to within half a
/// column. The rotation common to all lasers is chosen to centre the offsets on 0. A ring without points at
/// the instants of the fullest ring keeps its offset. Returns false and changes nothing without times.
[[nodiscard]] bool find_whole_offsets(const std::vector<TimedCloud>& clouds,
                                      const std::vector<int>& row_of_ring, LidarModel& model);

}  // namespace mapless
