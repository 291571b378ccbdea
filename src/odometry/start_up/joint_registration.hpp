#pragma once

#include <optional>
#include <vector>

#include "odometry/registration/mapped_trajectory.hpp"

namespace mapless::inline v1 {

/// Registers a few consecutive scans at once, each to the map of all the others: what a sparse sensor's first
/// two scans do not tell of each other, the scans after them do. `knots` and `prior` are of the whole time,
/// UsableScan::interval counts in `knots`. The figures of the result are the last scan's. None where there is
/// no solution.
[[nodiscard]] std::optional<Registration> register_jointly(std::vector<TrajectoryKnot> knots,
                                                           const WindowPrior& prior,
                                                           const std::vector<UsableScan>& scans,
                                                           const RegistrationSettings& settings);

/// The same from a sensor at rest where `prior` has it, roughly at first: for scans of which no two tell how
/// it moved between them, but which all together do. Finds the motion of somebody who walks, not of a car.
[[nodiscard]] std::optional<Registration> register_from_rest(std::vector<TrajectoryKnot> knots,
                                                             const WindowPrior& prior,
                                                             const std::vector<UsableScan>& scans,
                                                             const RegistrationSettings& settings);

/// How many points agree with a motion, each scan's with the map of all the others.
[[nodiscard]] double agreement_of(const std::vector<TrajectoryKnot>& knots,
                                  const std::vector<UsableScan>& scans, const RegistrationSettings& settings);

}  // namespace mapless
