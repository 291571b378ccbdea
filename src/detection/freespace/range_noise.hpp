#pragma once

#include <mapless/detection/parameters.hpp>
#include <mapless/lidar/lidar_scan.hpp>

namespace mapless::inline v1 {

/// Standard deviation of the range noise of a scan [m], estimated from the second differences of consecutive
/// ranges where the scan is smoothest, which errs to the low side. 0 if too few firings are consecutive.
[[nodiscard]] double range_noise_m(const LidarScan& scan);

/// The tolerance is at least this many standard deviations of the range noise: below, static surfaces look
/// seen through. Measured: docs/notebook/detection.md, "a tolerance of four standard deviations".
inline constexpr double kToleratedDeviations = 4;
/// `parameters` with tolerance_m raised to that for the noise of `scan`.
[[nodiscard]] VotingParameters with_tolerance_for_noise(VotingParameters parameters, const LidarScan& scan);

}  // namespace mapless
