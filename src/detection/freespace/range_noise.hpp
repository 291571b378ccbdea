#pragma once

#include <mapless/detection/parameters.hpp>
#include <mapless/lidar/lidar_scan.hpp>

namespace mapless::inline v1 {

/// Standard deviation of the noise of the scan's ranges [m], a little below it if anything: by how far ranges
/// of consecutive firings are off the line between their neighbours, where the scan is smoothest. 0 where too
/// few are consecutive to tell.
[[nodiscard]] double range_noise_m(const LidarScan& scan);

/// With a tolerance of at least kToleratedDeviations of the scan's noise: nearer than that, what stands looks
/// seen through.
inline constexpr double kToleratedDeviations = 4;
[[nodiscard]] VotingParameters for_noise_of(const LidarScan& scan, VotingParameters parameters);

}  // namespace mapless
