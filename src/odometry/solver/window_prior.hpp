#pragma once

#include <vector>

#include "odometry/solver/window_solver.hpp"

namespace mapless::inline v1 {

/// A Gaussian over consecutive knots: the information of all earlier scans, once the knots before these are
/// marginalised.
struct WindowPrior {
  std::vector<TrajectoryKnot> mean;
  /// Information matrix of the perturbations from the mean, block tridiagonal as in WindowSystem.
  std::vector<Matrix12d> diagonal;
  std::vector<Matrix12d> above;
};

/// The prior of a single knot.
[[nodiscard]] WindowPrior prior_of(const TrajectoryKnot& mean, const Matrix12d& information);

/// The marginal of the last `count` of `knots` (of all knots if there are fewer). `system` and `solution` are
/// those of the step that led to `knots`.
[[nodiscard]] WindowPrior marginal_of_last(std::size_t count, const std::vector<TrajectoryKnot>& knots,
                                           const WindowSystem& system, const WindowSolution& solution);

/// Error of a knot from its prior, [ln(T T_mean^-1); varpi - varpi_mean].
[[nodiscard]] Vector12d knot_error(const TrajectoryKnot& mean, const TrajectoryKnot& knot);

/// Adds the prior to the normal equations of `knots`; its first knot is number `first` there.
void add_window_prior(const WindowPrior& prior, const std::vector<TrajectoryKnot>& knots, std::size_t first,
                      WindowSystem& system);

}  // namespace mapless
