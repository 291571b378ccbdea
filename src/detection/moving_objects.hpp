#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "detection/detection_pipeline.hpp"
#include <mapless/core/time.hpp>
#include <mapless/detection/detector.hpp>
#include <mapless/detection/object_tracker.hpp>

namespace mapless {

/// Follows the objects that a pipeline proposes and, with method "voting", tells those that move from those
/// that stand. Rays tell that something was elsewhere a while ago; whether it still goes on, the registration
/// of the whole object tells much better: a braking bus that slides within itself by centimetres.
///
/// An object begins to move with the speed `min_speed_mps` and an advance of `min_advance_m`, and a new one,
/// whose speed is not known yet, with the advance alone, if it has 15 points; a smaller one has to be seen
/// again. It moves until it is slower in two scans; the advance tells instead of the speed where the
/// registration hardly does, as of a wall, which slides along itself at any speed. It stands,
/// too, once it would have gone 1 m since any scan saw through a part of it. What stands is followed on for
/// as long as it is proposed.
class MovingObjects {
 public:
  explicit MovingObjects(const DetectorParameters& parameters) : parameters_(parameters) {}

  /// The detection, of what moves alone: numbers go to that, in the order they had.
  Detection judge(ProposedObjects proposed);

 private:
  struct State {
    bool moves = false, slow = false;
    double unproven_m = 0;  // gone by its speed since its last advance
    Time seen;
  };
  void update(const TrackedObject& object, float advance_m, Time now, State& state) const;
  void forget_absent(Time now);

  DetectorParameters parameters_;
  ObjectTracker tracker_;
  std::map<std::uint32_t, State> states_;  // by id
};

}  // namespace mapless
