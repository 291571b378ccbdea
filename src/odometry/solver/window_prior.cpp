#include "odometry/solver/window_prior.hpp"

#include <algorithm>

namespace mapless::inline v1 {
namespace {

Matrix12d knot_jacobian(const Vector12d& error) {
  Matrix12d J = Matrix12d::Identity();
  J.topLeftCorner<6, 6>() = left_jacobian_inverse(error.head<6>());
  return J;
}

}  // namespace

WindowPrior prior_of(const TrajectoryKnot& mean, const Matrix12d& information) {
  return {{mean}, {information}, {}};
}

WindowPrior marginal_of_last(std::size_t count, const std::vector<TrajectoryKnot>& knots,
                             const WindowSystem& system, const WindowSolution& solution) {
  const auto first = static_cast<std::ptrdiff_t>(knots.size() - std::min(count, knots.size()));
  WindowPrior out = {{knots.begin() + first, knots.end()},
                     {system.diagonal.begin() + first, system.diagonal.end()},
                     {system.above.begin() + first, system.above.end()}};
  out.diagonal.front() = solution.information[static_cast<std::size_t>(first)];
  return out;
}

Vector12d knot_error(const TrajectoryKnot& mean, const TrajectoryKnot& knot) {
  Vector12d e;
  e << (knot.T_v0 * mean.T_v0.inverse()).log(), knot.varpi - mean.varpi;
  return e;
}

void add_window_prior(const WindowPrior& prior, const std::vector<TrajectoryKnot>& knots, std::size_t first,
                      WindowSystem& system) {
  const std::size_t n = prior.mean.size();
  std::vector<Vector12d> e(n);
  std::vector<Matrix12d> J(n);
  for (std::size_t k = 0; k < n; ++k) {
    e[k] = knot_error(prior.mean[k], knots[first + k]);
    J[k] = knot_jacobian(e[k]);
    const Matrix12d JtW = J[k].transpose() * prior.diagonal[k];
    system.diagonal[first + k] += JtW * J[k];
    system.gradient[first + k] += JtW * e[k];
  }
  for (std::size_t k = 0; k + 1 < n; ++k) {
    const Matrix12d JtW = J[k].transpose() * prior.above[k];
    system.above[first + k] += JtW * J[k + 1];
    system.gradient[first + k] += JtW * e[k + 1];
    system.gradient[first + k + 1] += J[k + 1].transpose() * prior.above[k].transpose() * e[k];
  }
}

}  // namespace mapless
