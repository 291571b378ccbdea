#include "odometry/solver/measurement_terms.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace mapless::inline v1 {
namespace {

// Chosen: a right motion contradicts one of a million measurements with normal noise. The mean is tested by
// the deviation of a single measurement, because the errors of one sensor have a common part (bias, slip).
constexpr double kContradictionSigmas = 5;

// The measurements with first <= time < end.
struct Range {
  MotionMeasurements::const_iterator first, last;
};
Range between(const MotionMeasurements& all, Time first, Time end) {
  const auto earlier = [](const MotionMeasurement& m, Time t) { return m.time < t; };
  const auto begin = std::lower_bound(all.begin(), all.end(), first, earlier);
  return {begin, std::lower_bound(begin, all.end(), end, earlier)};
}

// Where `t` lies between two knots: 0 at the first, 1 at the second.
double part_of(const TrajectoryKnot& k1, const TrajectoryKnot& k2, Time t) {
  return (t - k1.time).seconds() / (k2.time - k1.time).seconds();
}

Vector6d varpi_between(const TrajectoryKnot& k1, const TrajectoryKnot& k2, double part) {
  return (1 - part) * k1.varpi + part * k2.varpi;
}

// Gradient and Hessian of half the squared error with respect to varpi.
struct Term {
  Vector6d gradient = Vector6d::Zero();
  Matrix6d hessian = Matrix6d::Zero();
};

Term term_of(const MotionMeasurement& measured, const Vector6d& varpi) {
  const double weight = 1 / (*measured.sigma * *measured.sigma);
  const Eigen::Vector3d error = measurement_error(measured, varpi);
  Term out;
  if (measured.quantity != MeasuredMotion::speed) {
    const Eigen::Index first = measured.quantity == MeasuredMotion::velocity ? 0 : 3;
    out.gradient.segment<3>(first) = weight * error;  // d error / d varpi = 1
    out.hessian.block<3, 3>(first, first) = weight * Eigen::Matrix3d::Identity();
    return out;
  }
  // (|v| - s)^2 / 2: across the direction of v the Hessian is 1 - s / |v|, of which the positive part is
  // used. At rest no direction is known: the term is left out unless the measured speed is 0 as well.
  const double speed = varpi.head<3>().norm();
  if (speed == 0 && measured.value.x() > 0) return out;
  const Eigen::Vector3d direction =
      speed > 0 ? Eigen::Vector3d(varpi.head<3>() / speed) : Eigen::Vector3d::Zero();
  const Eigen::Matrix3d along = direction * direction.transpose();
  const double across = speed > 0 ? std::max(0.0, 1 - measured.value.x() / speed) : 1;
  out.gradient.head<3>() = -weight * error.x() * direction;
  out.hessian.topLeftCorner<3, 3>() = weight * (along + across * (Eigen::Matrix3d::Identity() - along));
  return out;
}

}  // namespace

Eigen::Vector3d measurement_error(const MotionMeasurement& measured, const Vector6d& varpi) {
  switch (measured.quantity) {
    case MeasuredMotion::velocity:
      return measured.value + varpi.head<3>();
    case MeasuredMotion::angular_velocity:
      return measured.value + varpi.tail<3>();
    case MeasuredMotion::speed:
      break;
  }
  return {measured.value.x() - varpi.head<3>().norm(), 0, 0};
}

void add_measurements(const MotionMeasurements& measurements, const std::vector<TrajectoryKnot>& knots,
                      std::size_t k, WindowSystem& system) {
  const auto [first, last] = between(measurements, knots[k].time, knots[k + 1].time);
  for (auto measured = first; measured != last; ++measured) {
    const double part = part_of(knots[k], knots[k + 1], measured->time);
    const Term term = term_of(*measured, varpi_between(knots[k], knots[k + 1], part));
    const std::array parts = {1 - part, part};
    for (std::size_t i = 0; i < 2; ++i) {
      system.gradient[k + i].tail<6>() += parts[i] * term.gradient;
      system.diagonal[k + i].bottomRightCorner<6, 6>() += parts[i] * parts[i] * term.hessian;
    }
    system.above[k].bottomRightCorner<6, 6>() += parts[0] * parts[1] * term.hessian;
  }
}

bool contradict(const std::vector<TrajectoryKnot>& knots, const MotionMeasurements& measurements) {
  std::array<Eigen::Vector3d, 3> sums;
  sums.fill(Eigen::Vector3d::Zero());
  std::array<int, 3> counts = {};
  for (std::size_t k = 0; k + 1 < knots.size(); ++k) {
    const auto [first, last] = between(measurements, knots[k].time, knots[k + 1].time);
    for (auto measured = first; measured != last; ++measured) {
      const double part = part_of(knots[k], knots[k + 1], measured->time);
      const auto quantity = static_cast<std::size_t>(measured->quantity);
      sums[quantity] +=
          measurement_error(*measured, varpi_between(knots[k], knots[k + 1], part)) / *measured->sigma;
      ++counts[quantity];
    }
  }
  for (std::size_t i = 0; i < sums.size(); ++i) {
    if (sums[i].norm() > kContradictionSigmas * counts[i]) return true;
  }
  return false;
}

}  // namespace mapless
