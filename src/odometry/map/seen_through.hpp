#pragma once

#include <vector>

#include "odometry/registration/time_bins.hpp"
#include <mapless/lidar/lidar_scan.hpp>

namespace mapless::inline v1 {

/// How far a scan saw at least in every direction. Points of another scan that lie well within what it saw
/// were not there then: they have moved, or the motion between both scans is wrong. Many of them mean the
/// latter: a wrong motion sees through walls.
class SeenThrough {
 public:
  explicit SeenThrough(const LidarScan& scan);

  struct Count {
    int judged = 0;   ///< points in a direction in which the scan saw something
    int through = 0;  ///< of those, points it would have had to look through
  };
  /// `own`: of this scan's time. `bins` and `interval`: points of another scan, and of its time.
  [[nodiscard]] Count count(const KnotInterval& own, const TimeBins& bins,
                            const KnotInterval& interval) const;

 private:
  struct Direction {
    int row, column;
  };
  [[nodiscard]] static Direction direction_of(const Eigen::Vector3d& p_v, double range_m);
  [[nodiscard]] double nearest_about(const Direction& direction) const;

  std::vector<float> nearest_m_;    // by row and column; 0: nothing seen
  std::vector<Time> column_times_;  // when the sensor looked there
};

}  // namespace mapless
