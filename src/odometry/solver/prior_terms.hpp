#pragma once

#include <limits>

#include "odometry/solver/window_solver.hpp"

namespace mapless::inline v1 {

/// Power spectral densities Qc of the white noise on acceleration, equal on the three axes of translation and
/// on those of rotation (method.md section 6, "Qc").
struct AccelerationDensity {
  double translation;  ///< [m^2/s^3]
  double rotation;     ///< [rad^2/s^3]
  /// Upper bounds of the density within an interval, that is, of the difference between its mean velocity and
  /// the mean of those at its ends. Registration cannot observe that difference, because the map has the same
  /// distortion as the scans it was built from; and within a scan every motion is smooth. Over an interval
  /// longer than a scan at 10 Hz the bound holds in part (motion_information).
  double max_within_translation = std::numeric_limits<double>::infinity();
  double max_within_rotation = std::numeric_limits<double>::infinity();
};

/// Error of the motion prior between two knots, e = [xi - dt varpi_1; J^-1(xi) varpi_2 - varpi_1].
[[nodiscard]] Vector12d motion_error(const TrajectoryKnot& k1, const TrajectoryKnot& k2);
/// Its derivative with respect to (pose 1, varpi 1, pose 2, varpi 2).
[[nodiscard]] Eigen::Matrix<double, 12, 24> motion_jacobian(const TrajectoryKnot& k1,
                                                            const TrajectoryKnot& k2);
/// Q^-1 of that error for an interval of `dt` seconds. The part e_p / dt - e_v / 2, which happens within the
/// interval, has the bounded density (AccelerationDensity); in an interval of more than .12 s a part of the
/// free one as well.
[[nodiscard]] Matrix12d motion_information(double dt, const AccelerationDensity& density);

/// Adds the motion prior between knots k and k + 1.
void add_motion_prior(const std::vector<TrajectoryKnot>& knots, std::size_t k,
                      const AccelerationDensity& density, WindowSystem& system);

}  // namespace mapless
