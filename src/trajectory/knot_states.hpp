#pragma once

#include <span>
#include <string>

#include <mapless/trajectory/trajectory.hpp>

namespace mapless::inline v1 {

/// Trajectory::at and Trajectory::sample of the Gaussian process over `knots` (at least two, by strictly
/// increasing time). Both throw TrajectoryDomainError naming `source` outside the knots' times.
[[nodiscard]] TrajectoryState state_between(std::span<const TrajectoryKnot> knots, Time t,
                                            const std::string& source);
void sample_between(std::span<const TrajectoryKnot> knots, Time first, Duration period,
                    const std::string& source, std::span<TrajectoryState> states);

}  // namespace mapless
