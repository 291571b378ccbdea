#pragma once

#include <random>
#include <vector>

#include "odometry/solver/prior_terms.hpp"

namespace mapless::test {

inline Vector12d random_step(std::mt19937& generator, double pose, double velocity) {
  std::normal_distribution<double> normal;
  Vector12d out;
  for (int i = 0; i < 12; ++i) out[i] = normal(generator) * (i < 6 ? pose : velocity);
  return out;
}

/// Knots 0.1 s apart of a sensor that translates and rotates, both at slightly changing rates.
inline std::vector<TrajectoryKnot> moving_knots(int count, std::mt19937& generator) {
  Vector6d varpi;
  varpi << -8, 0.3, -0.1, 0.1, -0.2, -0.6;
  std::vector<TrajectoryKnot> knots = {{Time::from_seconds(3), SE3::exp(0.4 * varpi), varpi}};
  while (static_cast<int>(knots.size()) < count) {
    const TrajectoryKnot& last = knots.back();
    const TrajectoryKnot next = {last.time + Duration::from_seconds(0.1),
                                 SE3::exp(0.1 * last.varpi) * last.T_v0, last.varpi};
    knots.push_back(perturbed(next, random_step(generator, 0.01, 0.1)));
  }
  return knots;
}

/// Derivative of f with respect to the 24 perturbations of two knots, by central differences.
template <class Function>
Eigen::MatrixXd numerical_jacobian(const TrajectoryKnot& k1, const TrajectoryKnot& k2, Function&& f) {
  constexpr double h = 1e-6;
  const auto moved = [&](int column, double amount) {
    Vector12d step = Vector12d::Zero();
    step[column % 12] = amount;
    return column < 12 ? f(perturbed(k1, step), k2) : f(k1, perturbed(k2, step));
  };
  Eigen::MatrixXd J(f(k1, k2).size(), 24);
  for (int c = 0; c < 24; ++c) J.col(c) = (moved(c, h) - moved(c, -h)) / (2 * h);
  return J;
}

}  // namespace mapless::test
