#pragma once

#include <cstdint>
#include <map>

#include <mapless/core/time.hpp>
#include <mapless/detection/parameters.hpp>
#include <mapless/detection/tracked_object.hpp>

namespace mapless {

/// Whether an object that is followed moves, and what of its last scan the next one has to know.
struct MotionState {
  bool moves = false;
  bool slow = false;
  double unproven_m = 0;  ///< gone by its speed since its last advance
  Time seen;              ///< start of the scan
};

/// The state once the scan that starts at `now` showed the object, with an advance
/// (RegionGrowthResult::advance_m).
///
/// An object begins to move with the speed `min_speed_mps` and an advance of `min_advance_m`, and a new one
/// (age 1), whose speed is not known yet, with the advance alone, if it has 15 points; a smaller one has to
/// be seen again. It moves until it is slower in two of its scans in a row; the advance tells instead of the
/// speed where the registration hardly does, as of a wall, which slides along itself at any speed. It stands,
/// too, once it would have gone 1 m by its speed since its last advance.
MotionState next_state(const MotionState& last, const TrackedObject& object, float advance_m, Time now,
                       const VotingParameters& parameters);

using MotionStates = std::map<std::uint32_t, MotionState>;  // by id

/// Drops those that ObjectTracker has forgotten: their ids do not come back.
void forget_absent(MotionStates& states, Time now);

}  // namespace mapless
