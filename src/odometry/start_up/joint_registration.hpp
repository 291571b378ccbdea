#pragma once

#include <optional>
#include <vector>

#include "odometry/registration/mapped_trajectory.hpp"

namespace mapless::inline v1 {

/// Registers a few consecutive scans at once, each to the map of all the others. Together they constrain a
/// motion that the first two scans of a sparse sensor leave open. `knots` and `prior` cover the whole time;
/// UsableScan::interval counts in `knots`. Inliers and degeneracy of the result are those of the last scan.
/// None if there is no solution.
[[nodiscard]] std::optional<Registration> register_jointly(std::vector<TrajectoryKnot> knots,
                                                           const WindowPrior& prior,
                                                           const std::vector<UsableScan>& scans,
                                                           RegistrationSettings settings);

/// The same, but the initial guess is a sensor at rest at the mean of `prior`, and the maps begin coarse: for
/// scans that no pairwise registration can solve. It finds walking speeds, not those of a car.
[[nodiscard]] std::optional<Registration> register_from_rest(std::vector<TrajectoryKnot> knots,
                                                             const WindowPrior& prior,
                                                             const std::vector<UsableScan>& scans,
                                                             const RegistrationSettings& settings);

/// The sum of the robust weights of all scans along a motion, each scan against the map of all the others.
[[nodiscard]] double soft_inliers_of(const std::vector<TrajectoryKnot>& knots,
                                     const std::vector<UsableScan>& scans,
                                     const RegistrationSettings& settings);

}  // namespace mapless
