#pragma once

#include <cstdint>
#include <cstdlib>
#include <vector>

#include <Eigen/Geometry>

#include <mapless/lidar/lidar_scan.hpp>
#include <mapless/trajectory/trajectory.hpp>

namespace mapless::inline v1 {

/// Points per parallel task. Chosen: many tasks per scan (60 and more), each long against the cost of
/// starting it.
inline constexpr std::size_t kPointsPerTask = 1024;

/// Transforms points between world and sensor at the instants of a scan. The trajectory is evaluated once per
/// column. Within one column period of that instant the motion is taken to first order, with an error of
/// dt^2/2 |omega| (|nu| + |omega| range): 2e-6 m at dt = 50 microseconds, |omega| = 200 deg/s, |nu| = 30 m/s
/// and a range of 100 m. For a larger dt the trajectory is evaluated at the point's own instant.
class SensorMotion {
 public:
  /// Throws TrajectoryDomainError unless the trajectory covers every column and return. Keeps a reference to
  /// the trajectory.
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
  std::vector<SE3> column_T_0v;                ///< the inverses of their T_v0

 private:
  [[nodiscard]] TrajectoryState exact_state(std::int32_t time_ns) const;

  const Trajectory& trajectory_;
  Time start_;
  std::int64_t period_ns_;
};

}  // namespace mapless
