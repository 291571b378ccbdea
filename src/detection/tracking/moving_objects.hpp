#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "detection/detection_pipeline.hpp"
#include "detection/tracking/completion/sliding_sides.hpp"
#include "detection/tracking/motion_classifier.hpp"
#include "detection/tracking/object_tracker.hpp"
#include "detection/tracking/straight_paths.hpp"
#include <mapless/detection/detection.hpp>
#include <mapless/detection/parameters.hpp>

namespace mapless::inline v1 {

// Tracking: from objects of single scans to moving objects over time. In: the objects that a pipeline
// proposes in each scan, by increasing time, with their evidence and the sensor's motion. Out: the same
// detection with moving objects alone, each with an id, velocity and box. Tracks, their filters and their
// classification are private to this folder: only MovingObjects is used from outside, and nothing of it feeds
// back into evidence or segmentation.

/// Tracks the proposed objects and, with method "voting", leaves those that move now in the detection. Rays
/// show that an object was elsewhere some scans ago; whether it still moves, the registration of its whole
/// surface shows better, down to centimetres. Static objects are tracked as long as they are proposed.
///
/// Moving objects get the ids 1, 2, ... in the order in which they are first found to move; a track that
/// rests for kLongestRest_s and moves again gets a new one. So ids do not depend on static tracks, nor on how
/// long ago a track began: parts of a drive, each with some scans before it, are numbered as the whole.
class MovingObjects {
 public:
  explicit MovingObjects(const DetectorParameters& parameters)
      : method_(parameters.method), classifier_(parameters.voting) {}

  /// The detection with moving objects alone, renumbered in their order.
  Detection classify(ObjectProposals proposed);

  /// What the last call decided, by number of the proposed object - 1.
  [[nodiscard]] const std::vector<TrackMotion>& motions() const { return motions_; }

  static constexpr double kLongestRest_s = 5;  ///< a short halt in traffic

 private:
  struct GivenId {
    std::uint32_t id = 0;
    Time moved;  // start of the last scan in which it moved
  };
  void give_ids(std::vector<TrackedObject>& moving, Time now);
  [[nodiscard]] std::uint32_t given_id(std::uint32_t track) const;  // 0: none
  /// Makes the rims of objects static.
  static void take_off(const std::vector<std::int32_t>& rims, Detection& detection);
  /// Makes objects static for which slides_with_sensor() holds.
  void stop_rails(const ObjectProposals& proposed, const std::vector<TrackedObject>& tracked);
  void stop_standing(const ObjectProposals& proposed, const Detection& detection);
  static void explain(const std::vector<std::uint32_t>& completing, Completion by, Detection& detection);
  void explain(const std::vector<ObjectEvidence>& evidence, const std::vector<bool>& moved,
               Detection& detection) const;

  DetectionMethod method_;
  MotionClassifier classifier_;
  ObjectTracker tracker_;
  StraightPaths paths_;
  std::vector<TrackedObject> movers_;  // of the scan before
  TrackMotions states_;
  SlidingSides sides_;
  std::vector<TrackMotion> motions_;
  std::map<std::uint32_t, GivenId> ids_;  // by id of the track
  std::uint32_t next_id_ = 1;
};

/// Keeps the elements of detection.tracked that move (`moves`: one per element) and numbers them 1, 2, ... in
/// their order. The points of the others become static, with GrowthVerdict::static_track in the trace.
void keep_moving(const std::vector<bool>& moves, Detection& detection);

}  // namespace mapless
