#include "detection/tracking/velocity_filter.hpp"

#include <algorithm>

#include <Eigen/Cholesky>

namespace mapless::inline v1 {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// The squared normalised innovation of three axes has mean 3, and exceeds this in 0.7 % of all cases (chi
// squared).
constexpr double kExpectedSquare = 12;
// Largest factor on the covariance after a larger one. Chosen: one outlier at most doubles it.
constexpr double kMaxInflation = 2;
// Factor on the noise on acceleration: the running mean of the squares over half of their mean of 3, since
// some objects turn, brake and bounce all the time. The running mean keeps kMemory of its value per
// observation, and one square counts at most kMaxNoiseFactor. Chosen: a memory of about three observations
// follows a braking car.
constexpr double kNoisePerSquare = 2.0 / 3;
constexpr double kMaxNoiseFactor = 60;
constexpr double kMemory = 0.7;

}  // namespace

VelocityFilter::VelocityFilter(Time time, const Vector3d& velocity_0, const Matrix3d& velocity_covariance_0,
                               double acceleration_density)
    : time_(time),
      acceleration_density_(acceleration_density),
      state_(Vector6d::Zero()),
      covariance_(Matrix6d::Zero()) {
  state_.segment<3>(3) = velocity_0;
  covariance_.block<3, 3>(3, 3) = velocity_covariance_0;
}

void VelocityFilter::predict(Time time) {
  const double dt = std::max(0.0, (time - time_).seconds());
  time_ = std::max(time, time_);
  state_.head<3>() += dt * state_.segment<3>(3);
  covariance_.topRows<3>() += dt * covariance_.middleRows<3>(3);
  covariance_.leftCols<3>() += dt * covariance_.middleCols<3>(3);
  const Matrix3d noise = std::max(1.0, noise_factor_) * acceleration_density_ * dt * Matrix3d::Identity();
  covariance_.block<3, 3>(0, 0) += dt * dt / 3 * noise;
  covariance_.block<3, 3>(0, 3) += dt / 2 * noise;
  covariance_.block<3, 3>(3, 0) += dt / 2 * noise;
  covariance_.block<3, 3>(3, 3) += noise;
}

void VelocityFilter::observe(std::size_t past, const Vector3d& displacement_0, const Matrix3d& covariance) {
  const auto at = static_cast<Eigen::Index>(6 + 3 * past);
  using Columns = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxStates, 3>;
  const Columns PHt = covariance_.leftCols<3>() - covariance_.middleCols<3>(at);
  const Matrix3d expected = PHt.topRows<3>() - PHt.middleRows<3>(at);
  const Vector3d innovation = displacement_0 - (state_.head<3>() - state_.segment<3>(at));
  const Matrix3d S = expected + covariance;
  const auto solver = S.ldlt();
  const Columns gain = solver.solve(PHt.transpose()).transpose();
  state_ += gain * innovation;
  covariance_ -= gain * PHt.transpose();
  // Prediction or measurement is wrong, and which of them is not known.
  const double square = innovation.dot(solver.solve(innovation));
  covariance_ *= std::clamp(square / kExpectedSquare, 1.0, kMaxInflation);
  noise_factor_ =
      kMemory * noise_factor_ + (1 - kMemory) * std::min(kNoisePerSquare * square, kMaxNoiseFactor);
  covariance_ = (0.5 * (covariance_ + covariance_.transpose())).eval();
}

void VelocityFilter::remember(std::size_t most) {
  const auto kept = static_cast<Eigen::Index>(3 * (std::min({remembered() + 1, most, kMaxRemembered}) - 1));
  // Positions are relative to the present one, which becomes 0.
  State x = state_;
  Covariance P = covariance_;
  for (Eigen::Index i = 6; i < 6 + kept; i += 3) {
    x.segment<3>(i) -= state_.head<3>();
    P.middleRows<3>(i) -= covariance_.topRows<3>();
  }
  const auto present = P.leftCols<3>();
  for (Eigen::Index i = 6; i < 6 + kept; i += 3) P.middleCols<3>(i) -= present;
  state_.setZero(9 + kept);
  state_.segment<3>(3) = x.segment<3>(3);
  state_.tail(kept) = x.segment(6, kept);
  covariance_.setZero(9 + kept, 9 + kept);
  covariance_.block<3, 3>(3, 3) = P.block<3, 3>(3, 3);
  covariance_.block(3, 9, 3, kept) = P.block(3, 6, 3, kept);
  covariance_.block(9, 3, kept, 3) = P.block(6, 3, kept, 3);
  covariance_.bottomRightCorner(kept, kept) = P.block(6, 6, kept, kept);
}

void VelocityFilter::loosen(double velocity_std_mps) {
  covariance_.block<3, 3>(3, 3) += velocity_std_mps * velocity_std_mps * Matrix3d::Identity();
}

}  // namespace mapless
