#pragma once

#include <vector>

#include <Eigen/Core>

#include <mapless/trajectory/trajectory.hpp>

namespace mapless::inline v1 {

using Vector12d = Eigen::Matrix<double, 12, 1>;
using Matrix12d = Eigen::Matrix<double, 12, 12>;

/// How the pose at the end of a scan was estimated.
enum class ScanOutcome {
  first,       ///< no earlier scan to register to: the sensor is taken to stand still until the next scan
  registered,  ///< registered to the map
  few_points,  ///< too few usable returns: extrapolated with the motion prior
  repeated,    ///< the same returns as the scan before, delivered again: extrapolated with the motion prior
  lost,        ///< too few inliers, or no solution: extrapolated with the motion prior
  restarted,   ///< lost several times in a row: extrapolated, and a new map begins with this scan
};

/// How well the inliers of a scan constrain each direction of translation (Zhang, Kaess and Singh, ICRA 2016,
/// analyse the same eigenvalues). The constraint ratio of a direction is the mean over the inliers of
/// (plane normal . direction)^2, the rotation being free to follow: 0 is unconstrained, 1 the most.
struct Degeneracy {
  Eigen::Vector3d constraint_ratio = Eigen::Vector3d::Zero();  ///< one per direction, increasing
  /// Columns, in the order of `constraint_ratio`: unit vectors in the sensor frame at the scan's end.
  Eigen::Matrix3d directions_v = Eigen::Matrix3d::Identity();
  /// The first `unconstrained` directions are estimated by the motion prior alone.
  int unconstrained = 0;
};

/// The result of one scan.
struct OdometryUpdate {
  /// Knots that this scan added or corrected, by increasing time. The last one is at the scan's end. Two
  /// later scans still correct a knot, because the velocity at the end of a scan shows in the scans after it.
  std::vector<TrajectoryKnot> knots;
  /// Covariance of the last knot: left perturbation of T_v0 (translation [m], rotation [rad]), then varpi
  /// ([m/s], [rad/s]).
  Matrix12d covariance = Matrix12d::Zero();
  ScanOutcome outcome = ScanOutcome::first;
  int iterations = 0;       ///< Gauss-Newton steps
  double inlier_ratio = 0;  ///< keypoints within the gate of a plane of the map, over all keypoints
  Degeneracy degeneracy;
  bool converged = false;
  /// The motion of the first scans is decided with this scan, but another motion explains them about as well.
  /// The speed may be wrong, and with it all later poses.
  bool ambiguous = false;
};

}  // namespace mapless
