#pragma once

#include <cstdint>

#include <Eigen/Core>

#include <mapless/core/time.hpp>

namespace mapless::inline v1 {

/// A thing that moves, as it is in one scan: where, and how fast, in the world frame 0. Its points are those
/// of Detection::object with its `number`; where they are at another instant t, velocity_0 (t - their own
/// instant) tells.
struct TrackedObject {
  std::uint32_t id = 0;      ///< 1, 2, ...: kept over scans, given once in a tracker's life
  std::uint16_t number = 0;  ///< of Detection::object, in this scan alone
  Time time;                 ///< mean instant of its points: centre, extent and velocity are of then
  int points = 0;
  /// Of the box about its points, each moved by the velocity to `time`; sides along the axes of the world
  /// [m].
  Eigen::Vector3d centre_0 = Eigen::Vector3d::Zero();
  Eigen::Vector3d extent_0 = Eigen::Vector3d::Zero();               ///< lengths of the sides of that box [m]
  Eigen::Vector3d velocity_0 = Eigen::Vector3d::Zero();             ///< [m/s]
  Eigen::Matrix3d velocity_covariance_0 = Eigen::Matrix3d::Zero();  ///< [m^2/s^2]
  int age = 1;  ///< scans from its first to this one, both counted

  [[nodiscard]] Eigen::Vector3d velocity_std_0() const {
    return velocity_covariance_0.diagonal().cwiseSqrt();
  }
};

}  // namespace mapless
