#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

#include <Eigen/Core>

#include "detection/detection_pipeline.hpp"
#include "detection/tracking/completion/sliding_side.hpp"
#include "detection/tracking/motion_classifier.hpp"
#include <mapless/core/time.hpp>
#include <mapless/detection/detection.hpp>

namespace mapless::inline v1 {

/// The sides of long bodies that started beside the sensor: a bus, a tram. Such a side slides along itself,
/// so each scan sees a surface where every scan before saw it, and standing explains its rays as well as
/// moving does. The ends of the body tell: where its front is was free, and where its rear was is free now.
///
/// The front is a dynamic object that surely moves. The side behind it (SideSearch) belongs to the same body
/// if its rear moved: at places behind its last points most rays of this scan pass through, and of the scans
/// of the last seconds, in which at this velocity the body was still there, most ended on a surface. So the
/// rear of what stands never looks: a wall, or a car parked beside the one that starts. And not if the front
/// itself hid, a second ago, the places that it has passed since: so the road behind a vehicle looks. A rear
/// once seen to move is taken to move on with the body's velocity for kRemembered_s.
class SlidingSides {
 public:
  /// `tracked`, `motions`: of this scan; `object`: number of the proposed object of each point, changed for
  /// the points taken. Returns these, increasing. Called once a scan. Nothing of it reaches tracking or later
  /// scans, so that no error grows.
  std::vector<std::uint32_t> take(const LidarScan& scan, const ObjectProposals& proposed,
                                  const std::vector<TrackedObject>& tracked,
                                  const std::vector<TrackMotion>& motions,
                                  std::vector<std::uint16_t>& object);

 private:
  struct SeenRear {
    Time time;
    Eigen::Vector3d place_0, velocity_0;
  };
  std::map<std::uint32_t, SeenRear> rears_;  // by id of the track
};

}  // namespace mapless
