#pragma once

#include <cstdint>
#include <map>

#include "detection/segmentation/object_evidence.hpp"
#include <mapless/core/time.hpp>
#include <mapless/detection/parameters.hpp>
#include <mapless/detection/tracked_object.hpp>

namespace mapless::inline v1 {

/// Whether an object that is followed moves, and what of its last scan the next one has to know.
struct MotionState {
  bool moves = false;
  bool slow = false;
  bool velocity_known = false;  ///< it was once
  int stood = 0;                ///< scans since it last moved in which its velocity was known, and slow
  double evidence = 0;          ///< votes of its scans, those of the last in full, of each before half
  int age = 0;                  ///< TrackedObject::age
  double unproven_m = 0;        ///< gone by its speed since its last advance
  Time seen;                    ///< start of the scan
};

/// The state once the scan that starts at `now` showed the object, with what rays told of it then.
///
/// An object begins to move with the speed `min_speed_mps`, an advance of `min_advance_m` and votes of
/// `min_evidence`, to which those of earlier scans count half for each scan they are back: border effects are
/// small and gone in the next scan. A solid body takes a quarter of them, what flickers half as many again
/// until its velocity is known (Body). From its third scan on it takes more of them by as much as the
/// standard deviation of its velocity is above 0.5 m/s, and half of that to go on. A speed that is known has
/// to differ from 0 by two standard deviations then, too, and of what stood in three scans the advance has to
/// be half of what that speed makes in kRecentGap scans. It moves until it is slower in two of its scans in a
/// row, for the second of which it is enough that it may stand by its standard deviation, or in one that
/// shows no such advance either; the advance tells instead of the speed where the registration hardly does,
/// as of a wall, which slides along itself at any speed. It stands, too, once it would have gone 1 m by its
/// speed since its last advance; and while its velocity was never known, from its third scan on with less
/// than twice the votes it takes, in its second where there are more against it than for it.
MotionState next_state(const MotionState& last, const TrackedObject& object, const ObjectEvidence& evidence,
                       Time now, const VotingParameters& parameters);

using MotionStates = std::map<std::uint32_t, MotionState>;  // by id

/// Drops those that ObjectTracker has forgotten: their ids do not come back.
void forget_absent(MotionStates& states, Time now);

}  // namespace mapless
