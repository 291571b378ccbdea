#pragma once

#include <vector>

#include <mapless/lidar/lidar_scan.hpp>

namespace mapless::test {

inline constexpr int kSmallColumns = 24;

/// A scan of few lasers, a hundredth of a radian apart, and kSmallColumns columns: a return at `range_m` in
/// every cell, but for those in `missing` (laser by laser; empty: none), whose ray never came back. One
/// azimuth offset per laser, in columns.
[[nodiscard]] LidarScan small_scan(const std::vector<double>& offsets_in_columns, double range_m = 5,
                                   const std::vector<char>& missing = {},
                                   SpinDirection direction = SpinDirection::clockwise);

}  // namespace mapless::test
