#pragma once

#include <cstddef>
#include <span>

#include "odometry/solver/prior_terms.hpp"

namespace mapless::inline v1 {

/// Most knots that estimate_density() reads: the last ones.
inline constexpr std::size_t kDensityKnots = 21;

/// Estimates the power spectral density of the acceleration over the last 20 intervals between knots, for the
/// motion prior of the next scan: a car on a motorway and a hand-held sensor differ by a factor of a thousand
/// (method.md section 6, "Qc"). It uses the mean velocity of each interval, which the points constrain far
/// better than the velocity at a knot. `expected` enters the mean with the weight of two intervals.
[[nodiscard]] AccelerationDensity estimate_density(std::span<const TrajectoryKnot> knots,
                                                   const AccelerationDensity& expected);

}  // namespace mapless
