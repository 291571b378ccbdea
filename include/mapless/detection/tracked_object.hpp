#pragma once

#include <cstdint>

#include <Eigen/Core>

#include <mapless/core/time.hpp>

namespace mapless::inline v1 {

/// A dynamic object in one scan, in the world frame 0: its place, velocity and track. Its points are the
/// returns with its `number` in Detection::object; a point measured at time t_i is at p_0 + velocity_0 (t -
/// t_i) at time t.
struct TrackedObject {
  std::uint32_t id = 0;      ///< of the track: 1, 2, ..., kept over scans and never reused
  std::uint16_t number = 0;  ///< in Detection::object, of this scan alone
  Time time;                 ///< mean instant of its points; centre, extent and velocity are at this time
  int points = 0;            ///< number of its points
  /// Box of its points, each moved with velocity_0 to `time`; its sides are along the axes of the world.
  Eigen::Vector3d centre_0 = Eigen::Vector3d::Zero();               ///< [m]
  Eigen::Vector3d extent_0 = Eigen::Vector3d::Zero();               ///< lengths of the sides [m]
  Eigen::Vector3d velocity_0 = Eigen::Vector3d::Zero();             ///< of its visible surface [m/s]
  Eigen::Matrix3d velocity_covariance_0 = Eigen::Matrix3d::Zero();  ///< [m^2/s^2]
  int age = 1;  ///< scans since the track began, the first and this one counted

  /// Standard deviation of the velocity along each axis of the world [m/s].
  [[nodiscard]] Eigen::Vector3d velocity_std_0() const {
    return velocity_covariance_0.diagonal().cwiseSqrt();
  }
};

}  // namespace mapless
