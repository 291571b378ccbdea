#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include <mapless/lidar/lidar_scan.hpp>
#include <mapless/odometry/parameters.hpp>

namespace mapless::inline v1 {

// keypoints/ reduces a scan to the points that the odometry uses. A LidarScan and the parameters go in;
// points for the map (thin) and, of these, keypoints for registration (select_keypoints) come out. It has no
// state.

/// A return that the odometry uses.
struct ScanPoint {
  Eigen::Vector3f position_v;  ///< sensor frame at its own instant [m]
  float range_m;
  std::int32_t time_ns;  ///< since the start of the scan
  std::int32_t laser;
  std::uint32_t return_index;  ///< in LidarScan::returns
  unsigned pass = 0;           ///< its pass in pass_order
};

/// Selects about `max_scan_points` returns (all if there are fewer) with ranges between `min_range_m` and
/// `map_radius_m`, in the order of the returns. Near returns are thinned most, so that surfaces seen head-on
/// have about the same density of points at any range.
[[nodiscard]] std::vector<ScanPoint> thin(const LidarScan& scan, const OdometryParameters& parameters);

/// The r^2 for which the sum over `squares` (squared ranges [m^2]) of min(1, square / r^2) equals `target`,
/// with 0 < target < number of squares. Beyond r all returns are used; nearer ones with probability square /
/// r^2.
[[nodiscard]] double full_density_square(std::vector<float> squares, double target);

/// A permutation of 0 ... size - 1 in passes over the whole range, each pass with a stride of 40: any few
/// hundred consecutive elements come from all over the scan.
[[nodiscard]] std::vector<std::uint32_t> pass_order(std::size_t size);

/// A permutation of 0 ... size - 1 with a constant step near the golden section of `size` and coprime to it,
/// so that consecutive elements are far apart.
[[nodiscard]] std::vector<std::uint32_t> golden_order(std::size_t size);

}  // namespace mapless
