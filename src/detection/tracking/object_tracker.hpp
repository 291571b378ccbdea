#pragma once

#include <memory>
#include <vector>

#include "detection/freespace/ray_image.hpp"
#include <mapless/detection/detection.hpp>
#include <mapless/trajectory/trajectory.hpp>

namespace mapless::inline v1 {

/// Tracks the objects of consecutive detections and estimates their velocity. In: the objects that
/// segmentation proposes in each scan, as numbers of its points, and the sensor's trajectory. Out: one
/// TrackedObject for each, with an id that is kept over scans. Nothing of a track may be changed from
/// outside; which tracks are dynamic is decided after it, by MotionClassifier.
///
/// Each track is predicted with its velocity and associated one-to-one with the object it shares most points
/// with (object_association.hpp). The velocity comes from registering the object's points to those of earlier
/// scans, every point at its own instant, by distances to local planes and between silhouette edges
/// (object_registration.hpp). A Kalman filter with white noise on acceleration estimates velocity and
/// displacements (velocity_filter.hpp). A direction that the points do not constrain, as a wall along itself,
/// has a large standard deviation. No up direction, ground or class is assumed.
class ObjectTracker {
 public:
  ObjectTracker();
  ~ObjectTracker();
  ObjectTracker(ObjectTracker&&) noexcept;
  ObjectTracker& operator=(ObjectTracker&&) noexcept;

  /// One element for each object of the next detection, by Detection::object. `trajectory` has to cover the
  /// instants of its dynamic points; `rays` is the image of its scan. Throws InputError for a scan that does
  /// not start after the last one or that was compensated for motion before, and TrajectoryDomainError; the
  /// tracker is then as it was before the call.
  std::vector<TrackedObject> process(const Detection& detection, const Trajectory& trajectory,
                                     const std::shared_ptr<const RayImage>& rays);

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace mapless
