#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include <mapless/detection/stages.hpp>
#include <mapless/detection/tracked_object.hpp>
#include <mapless/lidar/lidar_scan.hpp>

namespace mapless::inline v1 {

/// Wall time of each step for one scan [s].
struct StageSeconds {
  double compensation = 0;
  double neighbours = 0;  ///< building the search structure
  double normals = 0;
  double comparison = 0;  ///< method "published", like the next two
  double backward = 0;
  double forward = 0;
  double evidence = 0;  ///< method "voting": of all reference scans
  double filter = 0;
  double region_growth = 0;
  double tracking = 0;

  [[nodiscard]] double total() const {
    return compensation + neighbours + normals + comparison + backward + forward + evidence + filter +
           region_growth + tracking;
  }
  [[nodiscard]] StageSeconds operator+(const StageSeconds& o) const {
    return {compensation + o.compensation, neighbours + o.neighbours, normals + o.normals,
            comparison + o.comparison,     backward + o.backward,     forward + o.forward,
            evidence + o.evidence,         filter + o.filter,         region_growth + o.region_growth,
            tracking + o.tracking};
  }
};

/// The detection of one scan: which of its points are dynamic, and the objects they form. `trace` and
/// `object` have one element per return of `scan`, in its order.
struct Detection {
  std::shared_ptr<const LidarScan> scan;
  std::size_t sequence_number = 0;    ///< 0 for the first scan the detector was given
  std::vector<StageTrace> trace;      ///< verdict of each stage
  std::vector<std::uint16_t> object;  ///< 0: static; 1, 2, ...: the dynamic object of this scan it belongs to
  int objects = 0;                    ///< number of dynamic objects
  std::vector<TrackedObject> tracked;  ///< their tracks, ordered by number
  StageSeconds seconds;

  /// Whether return i is dynamic.
  [[nodiscard]] bool dynamic(std::size_t i) const { return object[i] != 0; }
};

}  // namespace mapless
