#pragma once

#include "odometry/registration/time_bins.hpp"

namespace mapless::inline v1 {

/// How well the points hold each direction of translation of the whole scan, T_v0 being the sensor at the
/// scan's end. Directions with a share below `min_share` count as held by the prior.
[[nodiscard]] Degeneracy find_degeneracy(const std::vector<BinSums>& sums, const SE3& T_v0, double min_share);

/// Takes what the points say of the directions held by the prior out of their sums, so that a motion of the
/// whole scan along them (with the rotation that goes with it) costs nothing.
void leave_to_prior(const Degeneracy& degeneracy, const SE3& T_v0, std::vector<BinSums>& sums);

}  // namespace mapless
