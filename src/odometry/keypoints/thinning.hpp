#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include <mapless/lidar/lidar_scan.hpp>
#include <mapless/odometry/parameters.hpp>

namespace mapless::inline v1 {

/// A return of a scan that odometry uses.
struct ScanPoint {
  Eigen::Vector3f position_v;  ///< at its own instant [m]
  float range_m;
  std::int32_t time_ns;  ///< since the start of the scan
  std::int32_t laser;
  std::uint32_t return_index;  ///< in LidarScan::returns
  unsigned pass = 0;           ///< of in_passes
};

/// About `max_scan_points` returns, or all where there are fewer: what is near is thinned most, so that
/// surfaces seen head-on keep about the same density at any range. In the order of the returns. Those nearer
/// than `min_range_m` or beyond `map_radius_m` are not used.
[[nodiscard]] std::vector<ScanPoint> thin(const LidarScan& scan, const OdometryParameters& parameters);

/// Of squared ranges [m^2], the r^2 for which the sum of min(1, square / r^2) is `target`, which is more than
/// 0 and less than there are: beyond r all returns are used, of nearer ones that share.
[[nodiscard]] double full_square_of(std::vector<float> squares, double target);

/// Every index once: all are gone through several times, every time for others far apart. Any few hundred
/// that follow one another are of everywhere.
[[nodiscard]] std::vector<std::uint32_t> in_passes(std::size_t size);

/// Every index once, neighbours far apart: a step near the golden section, and prime to the size.
[[nodiscard]] std::vector<std::uint32_t> mixed_order(std::size_t size);

}  // namespace mapless
