#pragma once

#include <vector>

#include "odometry/registration/time_bins.hpp"
#include <mapless/geometry/compensated_scan.hpp>
#include <mapless/lidar/lidar_scan.hpp>

namespace mapless::inline v1 {

/// The freespace of one scan, by direction from the sensor: the shortest range in each cell of 2 degrees of
/// elevation by 1 degree of azimuth. In: a scan. Out: how many points of another scan lie in its freespace
/// under a hypothesis of the motion. Points there were not there when this scan was taken: they have moved,
/// or the hypothesis is wrong. Many mean that it is wrong.
///
/// This is apart from FreespaceProbe (detection), which observes single points exactly, because at start-up
/// the motion is what is sought: FreespaceProbe's rays need the pose of each column, which each of dozens of
/// hypotheses changes. Here nothing but the point's position in the sensor frame depends on the motion, and
/// cells are wide enough for motions that are still wrong by degrees. Both share FreespaceVerdict and
/// compare_ranges; tests/detection/freespace/freespace_agreement_test.cpp compares them with the same oracle.
class CoarseFreespace {
 public:
  explicit CoarseFreespace(const LidarScan& scan);

  /// `p_v`: a point in the sensor frame at the instant the sensor observed its direction [m].
  [[nodiscard]] FreespaceVerdict verdict(const Eigen::Vector3d& p_v) const;

  /// How many points of another scan lie inside. `own`: the motion at this scan's time. `bins` and
  /// `interval`: the points, and the motion at their time.
  [[nodiscard]] int count_inside(const KnotInterval& own, const TimeBins& bins,
                                 const KnotInterval& interval) const;

 private:
  struct Direction {
    int row, column;
  };
  [[nodiscard]] static Direction direction_of(const Eigen::Vector3d& p_v, double range_m);
  [[nodiscard]] double shortest_about(const Direction& direction) const;

  std::vector<float> shortest_m_;   // by row and column; 0: no return
  std::vector<Time> column_times_;  // when the sensor observed that azimuth
};

}  // namespace mapless
