#pragma once

#include <vector>

#include "odometry/solver/window_solver.hpp"

namespace mapless::inline v1 {

/// What is known beforehand of a few knots that follow one another: after marginalisation, all that the knots
/// before them and the scans until then tell.
struct WindowPrior {
  std::vector<TrajectoryKnot> mean;
  /// The information of the perturbations from there, block tridiagonal as in WindowSystem.
  std::vector<Matrix12d> diagonal;
  std::vector<Matrix12d> above;
};

/// Of one knot.
[[nodiscard]] WindowPrior prior_of(const TrajectoryKnot& mean, const Matrix12d& information);

/// Of the last `count` of `knots`, or of all where they are fewer, by a system whose last step led there.
[[nodiscard]] WindowPrior prior_of_last(std::size_t count, const std::vector<TrajectoryKnot>& knots,
                                        const WindowSystem& system, const WindowSolution& solution);

/// Error of a knot from its prior, [ln(T T_mean^-1); varpi - varpi_mean].
[[nodiscard]] Vector12d knot_error(const TrajectoryKnot& mean, const TrajectoryKnot& knot);

/// Adds what is known of the knots from number `first` on.
void add_window_prior(const WindowPrior& prior, const std::vector<TrajectoryKnot>& knots, std::size_t first,
                      WindowSystem& system);

}  // namespace mapless
