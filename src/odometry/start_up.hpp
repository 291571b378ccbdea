#pragma once

#include "odometry/scan_registration.hpp"
#include <mapless/lidar/lidar_scan.hpp>

namespace mapless {

/// Finds the motion of a sensor that may have been moving, or turning, from the very first scan on: registers
/// the scan in the last interval of `knots` to the first usable one, in the interval from `first_interval`
/// on, which is compensated anew with the motion found after every step; coarse to fine. None where there is
/// no solution.
[[nodiscard]] std::optional<Registration> start_up(std::vector<TrajectoryKnot> knots, const KnotPrior& prior,
                                                   const LidarScan& first, std::size_t first_interval,
                                                   const TimeBins& second,
                                                   const RegistrationSettings& settings,
                                                   const OdometryParameters& parameters);

}  // namespace mapless
