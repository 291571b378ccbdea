#include "odometry/solver/window_solver.hpp"

#include <Eigen/Cholesky>

namespace mapless::inline v1 {

void WindowSystem::add(std::size_t k, const Eigen::Matrix<double, 24, 24>& H,
                       const Eigen::Matrix<double, 24, 1>& g) {
  diagonal[k] += H.topLeftCorner<12, 12>();
  above[k] += H.topRightCorner<12, 12>();
  diagonal[k + 1] += H.bottomRightCorner<12, 12>();
  gradient[k] += g.head<12>();
  gradient[k + 1] += g.tail<12>();
}

std::optional<WindowSolution> solve(const WindowSystem& system) {
  const std::size_t n = system.diagonal.size();
  std::vector<Eigen::LLT<Matrix12d>> factors(n);
  std::vector<Vector12d> right(n);
  WindowSolution out;
  out.information.reserve(n);
  Matrix12d remaining = system.diagonal[0];
  right[0] = -system.gradient[0];
  for (std::size_t k = 0;; ++k) {
    out.information.push_back(remaining);
    factors[k].compute(remaining);
    if (factors[k].info() != Eigen::Success) return std::nullopt;
    if (k + 1 == n) break;
    const Matrix12d& B = system.above[k];
    const Matrix12d gain = factors[k].solve(B);
    right[k + 1] = -system.gradient[k + 1] - gain.transpose() * right[k];
    remaining = system.diagonal[k + 1] - B.transpose() * gain;
    remaining = (0.5 * (remaining + remaining.transpose())).eval();
  }
  out.step.resize(n);
  out.step[n - 1] = factors[n - 1].solve(right[n - 1]);
  for (std::size_t k = n - 1; k-- > 0;) {
    out.step[k] = factors[k].solve(right[k] - system.above[k] * out.step[k + 1]);
  }
  for (const Vector12d& step : out.step) {
    if (!step.allFinite()) return std::nullopt;
  }
  return out;
}

}  // namespace mapless
