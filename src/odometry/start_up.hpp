#pragma once

#include "odometry/scan_registration.hpp"

namespace mapless {

/// What odometry uses of a scan.
struct UsableScan {
  std::vector<ScanPoint> points;
  Time start;
  std::size_t interval = 0;  ///< the knot at its start
};

/// Finds the motion of a sensor that may have been moving, or turning, from the very first scan on: registers
/// the scan in the last interval of `knots` to the first one, which is compensated anew with the motion found
/// after every step. Tries velocities up to 40 m/s along the sensor's axes and turns up to 200 deg/s about
/// its third, and keeps what most points agree with. None where there is no solution.
[[nodiscard]] std::optional<Registration> start_up(const std::vector<TrajectoryKnot>& knots,
                                                   const KnotPrior& prior, const UsableScan& first,
                                                   const TimeBins& second,
                                                   const RegistrationSettings& settings);

}  // namespace mapless
