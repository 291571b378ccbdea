#pragma once

#include <cstddef>

#include <Eigen/Core>

#include <mapless/core/se3.hpp>
#include <mapless/core/time.hpp>

namespace mapless::inline v1 {

/// Kalman filter on the velocity of an object and its displacements since earlier scans, with white noise on
/// acceleration. Its state is (position, velocity, positions at the remembered scans, newest first) in the
/// world frame. Only differences of positions are observed, so their origin does not matter.
class VelocityFilter {
 public:
  static constexpr std::size_t kMaxRemembered = 5;

  /// `acceleration_density`: power spectral density of the noise on acceleration, per axis [m^2/s^3].
  VelocityFilter(Time time, const Eigen::Vector3d& velocity_0, const Eigen::Matrix3d& velocity_covariance_0,
                 double acceleration_density);

  /// Predicts to `time`; does nothing for an earlier one.
  void predict(Time time);
  /// Observes that the object moved by `displacement_0` [m] from remembered scan `past` (0: the newest) until
  /// now, with `covariance` [m^2]. An unexpected innovation makes the state more uncertain.
  void observe(std::size_t past, const Eigen::Vector3d& displacement_0, const Eigen::Matrix3d& covariance);
  /// Remembers the present position, and the newest `most` - 1 of those before; `most` is 1 to
  /// kMaxRemembered.
  void remember(std::size_t most);
  /// Adds this standard deviation to the velocity, per axis.
  void loosen(double velocity_std_mps);

  [[nodiscard]] Time time() const { return time_; }
  [[nodiscard]] std::size_t remembered() const { return static_cast<std::size_t>(state_.size() - 6) / 3; }
  [[nodiscard]] Eigen::Vector3d velocity() const { return state_.segment<3>(3); }
  [[nodiscard]] Eigen::Matrix3d velocity_covariance() const { return covariance_.block<3, 3>(3, 3); }

 private:
  Time time_;
  double acceleration_density_;
  double noise_factor_ = 1;  // on acceleration_density_
  static constexpr int kMaxStates = 6 + 3 * kMaxRemembered;
  using State = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxStates, 1>;
  using Covariance = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxStates, kMaxStates>;
  State state_;
  Covariance covariance_;
};

}  // namespace mapless
