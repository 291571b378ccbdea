#pragma once

#include <cstddef>

#include <Eigen/Core>

#include <mapless/core/se3.hpp>
#include <mapless/core/time.hpp>

namespace mapless::inline v1 {

/// Velocity of an object and its displacement since earlier scans: a Kalman filter with white noise on
/// acceleration whose state is (position, velocity, positions of remembered scans, newest first). Only
/// differences of positions are ever observed, so their origin is of no account.
class VelocityFilter {
 public:
  static constexpr std::size_t kMostRemembered = 5;

  VelocityFilter(Time time, const Eigen::Vector3d& velocity_0, const Eigen::Matrix3d& velocity_covariance_0,
                 double acceleration_density);

  /// On to `time`; not back.
  void predict(Time time);
  /// The object moved by `displacement_0` from remembered scan `past` (0: the newest) until now. What is far
  /// off what was expected counts less.
  void observe(std::size_t past, const Eigen::Vector3d& displacement_0, const Eigen::Matrix3d& covariance);
  /// Keeps the position of now, and of those kept before the newest `most - 1`; 1 to kMostRemembered.
  void remember(std::size_t most);
  /// At least so uncertain [m/s].
  void loosen(double velocity_std_mps);

  [[nodiscard]] Time time() const { return time_; }
  [[nodiscard]] std::size_t remembered() const { return static_cast<std::size_t>(state_.size() - 6) / 3; }
  [[nodiscard]] Eigen::Vector3d velocity() const { return state_.segment<3>(3); }
  [[nodiscard]] Eigen::Matrix3d velocity_covariance() const { return covariance_.block<3, 3>(3, 3); }

 private:
  Time time_;
  double acceleration_density_;
  double growth_ = 1;  // of the noise on acceleration
  static constexpr int kMostStates = 6 + 3 * kMostRemembered;
  using State = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMostStates, 1>;
  using Covariance = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMostStates, kMostStates>;
  State state_;
  Covariance covariance_;
};

}  // namespace mapless
