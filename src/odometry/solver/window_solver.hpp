#pragma once

#include <optional>
#include <vector>

#include "odometry/solver/knot_perturbation.hpp"

namespace mapless::inline v1 {

/// Normal equations H dx = -g of a chain of knots, in blocks of 12. H is symmetric and block tridiagonal.
struct WindowSystem {
  explicit WindowSystem(std::size_t knots)
      : diagonal(knots, Matrix12d::Zero()),
        above(knots == 0 ? 0 : knots - 1, Matrix12d::Zero()),
        gradient(knots, Vector12d::Zero()) {}

  std::vector<Matrix12d> diagonal;
  std::vector<Matrix12d> above;  ///< block (k, k + 1)
  std::vector<Vector12d> gradient;

  /// Adds a term between knots k and k + 1, those of knot k first.
  void add(std::size_t k, const Eigen::Matrix<double, 24, 24>& H, const Eigen::Matrix<double, 24, 1>& g);
};

struct WindowSolution {
  std::vector<Vector12d> step;  ///< one per knot
  /// Block (k, k) of H once the knots before k are marginalised (Schur complement). The last one is the
  /// information matrix of the last knot.
  std::vector<Matrix12d> information;
};

/// Eliminates knot by knot, first to last, and substitutes back. None if the system is not positive definite
/// or not finite.
[[nodiscard]] std::optional<WindowSolution> solve(const WindowSystem& system);

}  // namespace mapless
