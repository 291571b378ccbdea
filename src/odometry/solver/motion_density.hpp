#pragma once

#include <span>

#include "odometry/solver/prior_terms.hpp"

namespace mapless::inline v1 {

/// How much the velocity of a sensor has changed of late, as the density that the motion prior is to have for
/// it: a car on a motorway and a sensor in the hand differ by a factor of a thousand. Taken from the mean
/// velocities of whole intervals between knots, which the points hold far better than the velocities of the
/// knots. `expected` counts like two of them.
[[nodiscard]] AccelerationDensity density_of(std::span<const TrajectoryKnot> knots,
                                             const AccelerationDensity& expected);

}  // namespace mapless
