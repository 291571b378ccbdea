#pragma once

#include <optional>
#include <vector>

#include "odometry/registration/mapped_trajectory.hpp"

namespace mapless::inline v1 {

/// Registers the first scans once more, from the last to the first: each to the map of the scans after it,
/// with the motion that these have, run backwards. The first scans, registered before anything was known, err
/// most, the last ones least. `scans`, at least three, and their UsableScan::interval are those of
/// register_jointly(), and so is the result: the pose of the first knot is as before, and so are the
/// steps of the last two scans. Measurements of other sensors are not used. None if a scan does not match.
[[nodiscard]] std::optional<std::vector<TrajectoryKnot>> follow_backwards(
    const std::vector<TrajectoryKnot>& knots, const std::vector<UsableScan>& scans,
    RegistrationSettings settings);

}  // namespace mapless
