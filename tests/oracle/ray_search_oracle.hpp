#pragma once

#include <vector>

#include <Eigen/Core>

#include <mapless/lidar/lidar_scan.hpp>
#include <mapless/trajectory/trajectory.hpp>

namespace mapless::test {

/// One measured ray, and how far a point is from it.
struct OracleRay {
  int laser = -1;
  int column = -1;
  double distance_m = 0;  ///< perpendicular, to the ray's line
  double range_m = 0;     ///< of the foot, along the ray
};

/// Brute force over every ray of a scan: each starts at its laser's own origin, at the instant that laser
/// fired (column time and firing offset), and goes one way only. Absent cells hold no ray.
class RaySearchOracle {
 public:
  RaySearchOracle(const LidarScan& scan, const Trajectory& trajectory);

  /// Least perpendicular distance of all rays whose foot is not behind their origin; of equals the lower
  /// laser, then the lower column. Laser -1 where there is none.
  [[nodiscard]] OracleRay nearest(const Eigen::Vector3d& q_0) const;
  /// The same for one ray, wherever its foot is.
  [[nodiscard]] OracleRay ray(int laser, int column, const Eigen::Vector3d& q_0) const;
  [[nodiscard]] Eigen::Vector3d direction_0(int laser, int column) const;
  [[nodiscard]] Eigen::Vector3d origin_0(int laser, int column) const;

 private:
  struct Line {
    int laser;
    int column;
    Eigen::Vector3d origin;
    Eigen::Vector3d direction;
  };
  [[nodiscard]] Line line(int laser, int column) const;

  const LidarScan& scan_;
  const Trajectory& trajectory_;
  std::vector<Line> lines_;
};

}  // namespace mapless::test
