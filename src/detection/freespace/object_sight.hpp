#pragma once

#include <memory>

#include <Eigen/Core>

#include <mapless/core/time.hpp>
#include <mapless/lidar/lidar_scan.hpp>
#include <mapless/trajectory/trajectory.hpp>

namespace mapless::inline v1 {

/// Asks a scan whether it looked through a place, near an instant: the sensor moves to first order from
/// there. Lasers are taken to start at the sensor's origin. FreespaceProbe is the exact thing; this needs no
/// preparation and serves to tell one motion of an object from another.
class SightLines {
 public:
  /// `state`: of the trajectory at `time`, an instant of the scan.
  SightLines(std::shared_ptr<const LidarScan> scan, const TrajectoryState& state, Time time);

  /// The rays next to it, of the laser above and of that below, all go on well behind it.
  [[nodiscard]] bool through(const Eigen::Vector3d& p_0) const;

 private:
  [[nodiscard]] Eigen::Vector3d in_sensor(const Eigen::Vector3d& p_0) const;
  [[nodiscard]] double column_of(double azimuth_rad, double azimuth_offset_rad) const;

  std::shared_ptr<const LidarScan> scan_;
  TrajectoryState state_;
  double t_s_;  // of the state, after the start of the scan
};

}  // namespace mapless
