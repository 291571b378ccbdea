#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include <mapless/trajectory/trajectory.hpp>

namespace mapless::inline v1 {

using Vector12d = Eigen::Matrix<double, 12, 1>;
using Matrix12d = Eigen::Matrix<double, 12, 12>;

/// How far the motion of a scan can be relied on.
enum class MotionState : std::uint8_t {
  good,        ///< the points determine every direction of the motion
  degenerate,  ///< a direction of the motion is open (OdometryUpdate::motion_covariance_v), few points
               ///< support its start, or its start is not decided yet
  lost,        ///< no motion: the pose is extrapolated, or the points do not support it
};
/// "good", "degenerate" or "lost".
[[nodiscard]] std::string_view name_of(MotionState state);

/// How the pose at the end of a scan was estimated.
enum class ScanOutcome {
  first,        ///< no earlier scan to register to: the sensor is taken to stand still until the next scan
  registered,   ///< registered to the map
  few_points,   ///< too few usable returns: extrapolated with the motion prior
  repeated,     ///< the same returns as the scan before, delivered again: extrapolated with the motion prior
  unmatched,    ///< too few inliers, or no solution: extrapolated with the motion prior
  unsupported,  ///< registered, but too few points agree, or edges or another sensor's measurements
                ///< contradict
  restarted,    ///< after a loss: its pose is extrapolated, and a new map begins with this scan
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

/// A start-up that finds no motion during this many scans, because the sensor sees nothing or scans do not
/// match, begins again with the next scan: the motion before stays extrapolated. Chosen: 10 s at 10 Hz, and
/// ten times the scans of the longest start-up that finds one.
inline constexpr std::size_t kMostStartUpScans = 100;

/// The result of one scan.
struct OdometryUpdate {
  /// Knots that this scan added or corrected, by increasing time. The last one is at the scan's end. Three
  /// later scans still correct a knot, because the velocity at the end of a scan shows in the scans after it.
  std::vector<TrajectoryKnot> knots;
  /// Covariance of the last knot: left perturbation of T_v0 (translation [m], rotation [rad]), then varpi
  /// ([m/s], [rad/s]).
  Matrix12d covariance = Matrix12d::Zero();
  ScanOutcome outcome = ScanOutcome::first;
  MotionState state = MotionState::good;
  /// Number of scans to which `state` applies, this one the last. More than 1 only where the motion of the
  /// first scans is decided: their states are known from this scan on. At most kMostStartUpScans.
  std::size_t decided_scans = 1;
  int iterations = 0;       ///< Gauss-Newton steps
  double inlier_ratio = 0;  ///< keypoints within the gate of a plane of the map, over all keypoints
  /// Mean weight of the keypoints in the robust loss: 1 on a plane of the map, towards 0 far from it, 0 for
  /// an outlier.
  double mean_robust_weight = 0;
  Degeneracy degeneracy;

  /// Covariance of the sensor's translation from the start of the scan to its end, `duration_s` later, in the
  /// sensor frame at its end [m^2].
  [[nodiscard]] Eigen::Matrix3d motion_covariance_v(double duration_s) const {
    return duration_s * duration_s * covariance.block<3, 3>(6, 6);
  }
};

}  // namespace mapless
