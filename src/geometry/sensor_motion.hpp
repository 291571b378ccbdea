#pragma once

#include <cstdint>
#include <cstdlib>
#include <vector>

#include <Eigen/Geometry>

#include <mapless/lidar/lidar_scan.hpp>
#include <mapless/trajectory/trajectory.hpp>

namespace mapless::inline v1 {

/// Maps points between world and sensor at the instants of a scan. The trajectory is asked once per column;
/// within a column period of that the sensor moves to first order, which errs by dt^2/2 |omega| (|nu| +
/// |omega| range): 1e-6 m at 50 microseconds, 200 deg/s, 30 m/s and 100 m. Farther away the trajectory is
/// asked for the point alone.
class SensorMotion {
 public:
  /// Throws TrajectoryDomainError unless the trajectory covers every column and return. Keeps references to
  /// both.
  SensorMotion(const LidarScan& scan, const Trajectory& trajectory);

  /// p_0 = T_0v(t) p_v, t = time_ns after the start of the scan.
  [[nodiscard]] Eigen::Vector3d to_world(const Eigen::Vector3d& p_v, int column, std::int32_t time_ns) const {
    const std::int64_t dt_ns = time_ns - column * period_ns_;
    if (std::abs(dt_ns) > period_ns_) return exact_state(time_ns).T_v0.inverse() * p_v;
    const auto c = static_cast<std::size_t>(column);
    const Vector6d& varpi = column_states[c].varpi;
    const Eigen::Vector3d step = varpi.head<3>() + varpi.tail<3>().cross(p_v);
    return column_T_0v[c] * (p_v - static_cast<double>(dt_ns) * 1e-9 * step);
  }

  /// p_v = T_v0(t) p_0.
  [[nodiscard]] Eigen::Vector3d to_sensor(const Eigen::Vector3d& p_0, int column,
                                          std::int32_t time_ns) const {
    const std::int64_t dt_ns = time_ns - column * period_ns_;
    if (std::abs(dt_ns) > period_ns_) return exact_state(time_ns).T_v0 * p_0;
    const auto c = static_cast<std::size_t>(column);
    const Vector6d& varpi = column_states[c].varpi;
    const Eigen::Vector3d p_v = column_states[c].T_v0 * p_0;
    return p_v + static_cast<double>(dt_ns) * 1e-9 * (varpi.head<3>() + varpi.tail<3>().cross(p_v));
  }

  std::vector<TrajectoryState> column_states;  ///< at LidarScan::column_time
  std::vector<SE3> column_T_0v;                ///< their inverses

 private:
  [[nodiscard]] TrajectoryState exact_state(std::int32_t time_ns) const;

  const Trajectory& trajectory_;
  Time start_;
  std::int64_t period_ns_;
};

}  // namespace mapless
