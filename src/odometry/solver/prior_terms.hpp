#pragma once

#include <limits>

#include "odometry/solver/window_solver.hpp"

namespace mapless::inline v1 {

/// Power spectral densities Qc of the white noise on acceleration, equal on the axes of each group.
struct AccelerationDensity {
  double translation;  ///< [m^2/s^3]
  double rotation;     ///< [rad^2/s^3]
  /// At most this for what happens within an interval: how far the mean velocity is from that of the ends. No
  /// registration sees it, as the map is bent like the scans it was made of, and however much a motion
  /// changes from scan to scan, it is smooth within one.
  double most_within_translation = std::numeric_limits<double>::infinity();
  double most_within_rotation = std::numeric_limits<double>::infinity();
};

/// Error of the motion prior between two knots, e = [xi - dt varpi_1; J^-1(xi) varpi_2 - varpi_1].
[[nodiscard]] Vector12d motion_error(const TrajectoryKnot& k1, const TrajectoryKnot& k2);
/// Its derivative to (pose 1, varpi 1, pose 2, varpi 2).
[[nodiscard]] Eigen::Matrix<double, 12, 24> motion_jacobian(const TrajectoryKnot& k1,
                                                            const TrajectoryKnot& k2);
/// Q^-1 of that error, with e_p / dt - e_v / 2, which is what happens within the interval, held as said
/// above.
[[nodiscard]] Matrix12d motion_information(double dt, const AccelerationDensity& density);

/// Adds the motion prior between knots k and k + 1.
void add_motion_prior(const std::vector<TrajectoryKnot>& knots, std::size_t k,
                      const AccelerationDensity& density, WindowSystem& system);

}  // namespace mapless
