#pragma once

#include <memory>

#include <Eigen/Core>

#include <mapless/core/time.hpp>
#include <mapless/lidar/lidar_scan.hpp>
#include <mapless/trajectory/trajectory.hpp>

namespace mapless::inline v1 {

/// Whether the rays of a scan passed through a place, near an instant: the sensor moves to first order from
/// there, and lasers are taken to start at its origin. Tracking compares hypotheses of an object's motion
/// with it. It needs no preparation of the scan, and asks for more than FreespaceProbe: rays that end half a
/// metre beyond the place.
class SightLines {
 public:
  /// `state`: of the trajectory at `time`, an instant of the scan.
  SightLines(std::shared_ptr<const LidarScan> scan, const TrajectoryState& state, Time time);

  /// True where the rays next to p_0, two of the laser above and two of that below, all end well beyond it;
  /// one of the four may be faulty.
  [[nodiscard]] bool through(const Eigen::Vector3d& p_0) const;

 private:
  [[nodiscard]] Eigen::Vector3d in_sensor(const Eigen::Vector3d& p_0) const;
  [[nodiscard]] double column_of(double azimuth_rad, double azimuth_offset_rad) const;

  std::shared_ptr<const LidarScan> scan_;
  TrajectoryState state_;
  double t_s_;  // of the state, after the start of the scan
};

}  // namespace mapless
