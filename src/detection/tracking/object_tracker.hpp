#pragma once

#include <memory>
#include <vector>

#include <mapless/detection/detection.hpp>
#include <mapless/detection/tracked_object.hpp>
#include <mapless/trajectory/trajectory.hpp>

namespace mapless::inline v1 {

/// Keeps the objects of consecutive detections apart over time and estimates their velocity.
///
/// An object is looked for where its velocity says; whose points it overlaps most keeps its id, one id for
/// one object of the scan. The velocity comes from registering the object's points to those of earlier scans,
/// every point at its own instant: distances to local planes, and places of the edges behind which a ray went
/// on. A Kalman filter (white noise on acceleration) holds velocity and the displacements since these scans.
/// What does not show in the points, as the motion of a wall along itself, has a large standard deviation.
/// There is no up, no ground and no class in it.
class ObjectTracker {
 public:
  ObjectTracker();
  ~ObjectTracker();
  ObjectTracker(ObjectTracker&&) noexcept;
  ObjectTracker& operator=(ObjectTracker&&) noexcept;

  /// Every object of the next detection, by its number there. The trajectory is asked for the instants of
  /// its dynamic points. Throws InputError for a scan that starts before the last one or was compensated by
  /// somebody else, TrajectoryDomainError; the tracker is then as it was before the call.
  std::vector<TrackedObject> process(const Detection& detection, const Trajectory& trajectory);

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace mapless
