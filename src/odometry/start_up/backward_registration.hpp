#pragma once

#include <optional>
#include <vector>

#include "odometry/registration/mapped_trajectory.hpp"

namespace mapless::inline v1 {

/// Registers the first scans once more, from the last to the first: each to the map of the scans after it,
/// with the motion that these have, run backwards. The first scans, registered before anything was known, err
/// most, the last ones least. There must be at least two `scans`; their UsableScan::interval counts in
/// `knots`, and that of the first is 0. The pose of the first knot stays as it is, and so do the steps of the
/// last two scans. Measurements of other sensors are not used. None if there is no solution, or none that
/// is_plausible(); a scan without inliers follows the prior.
[[nodiscard]] std::optional<std::vector<TrajectoryKnot>> follow_backwards(
    const std::vector<TrajectoryKnot>& knots, const std::vector<UsableScan>& scans,
    RegistrationSettings settings);

}  // namespace mapless
