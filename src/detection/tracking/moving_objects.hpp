#pragma once

#include <vector>

#include "detection/detection_pipeline.hpp"
#include "detection/tracking/motion_classifier.hpp"
#include "detection/tracking/object_tracker.hpp"
#include <mapless/detection/detection.hpp>
#include <mapless/detection/parameters.hpp>

namespace mapless::inline v1 {

/// Follows the objects that a pipeline proposes and, with method "voting", tells those that move from those
/// that stand (next_state). Rays tell that something was elsewhere a while ago; whether it still goes on, the
/// registration of the whole object tells much better: a braking bus that slides within itself by
/// centimetres. What stands is followed on for as long as it is proposed.
class MovingObjects {
 public:
  explicit MovingObjects(const DetectorParameters& parameters)
      : method_(parameters.method), classifier_(parameters.voting) {}

  /// The detection, of what moves alone: numbers go to that, in the order they had.
  Detection classify(ProposedObjects proposed);

 private:
  DetectionMethod method_;
  MotionClassifier classifier_;
  ObjectTracker tracker_;
  MotionStates states_;
};

/// Leaves those of detection.tracked that move (one element each), numbered 1, 2, ... in their order; the
/// points of the others become static, and `stopped` in the trace.
void keep_moving(const std::vector<bool>& moves, Detection& detection);

}  // namespace mapless
