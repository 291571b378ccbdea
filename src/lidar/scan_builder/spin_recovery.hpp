#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include <mapless/lidar/lidar_model.hpp>

namespace mapless::inline v1 {

/// The usable points of a scan by rising atan2(y, x), with the ring of each and, where recorded, its time.
struct TimedCloud {
  std::vector<Eigen::Vector3f> points;
  std::vector<std::int32_t> rings;  ///< negative: not to be used
  std::vector<std::int64_t> times_ns;
};

/// Turns a second, counter-clockwise positive, as the azimuths of each ring change with time: the median over
/// steps of a tenth of a radian and more. nullopt where the times do not show it.
[[nodiscard]] std::optional<double> spin_rate_hz(const std::vector<TimedCloud>& clouds);

/// Where azimuth offsets are known but for whole columns, finds the whole ones: all lasers of one instant
/// share the hub's angle. Each is then within half a column of the azimuth between its laser and the others
/// at that instant, up to a turn common to all, which is taken to centre them on 0. Rings without a point
/// about when the fullest ring has one keep theirs; false, and nothing changed, where there are no times.
[[nodiscard]] bool find_whole_offsets(const std::vector<TimedCloud>& clouds,
                                      const std::vector<int>& row_of_ring, LidarModel& model);

}  // namespace mapless
