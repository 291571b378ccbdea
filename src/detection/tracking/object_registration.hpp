#pragma once

#include <Eigen/Core>

#include "detection/tracking/object_snapshot.hpp"

namespace mapless::inline v1 {

/// Motion of an object between two of its snapshots.
struct RegisteredMotion {
  Eigen::Vector3d velocity_0 = Eigen::Vector3d::Zero();  ///< of the centre of the earlier snapshot [m/s]
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< [m^2/s^2]; large in unconstrained directions
  /// Share of the points that, moved, lie where rays of the other scan passed through, plus weighted
  /// distances of points and of edges from those of the other snapshot. 0: the motion explains all.
  double misfit = 0;
};

/// Registers `now` to the earlier snapshot `before`: the velocity, found by robust Gauss-Newton descent from
/// `start` [m/s], that minimises the distances of points from the planes of `before` and of edges across
/// their rays, every point at its own instant. Where the neighbourhoods are no planes, the shift of the mean
/// constrains the velocity weakly. A turn rate about the centre is estimated too, with a prior of 0.1 rad/s
/// around zero. Equations: docs/method.md, "Objects over time".
[[nodiscard]] RegisteredMotion register_snapshots(const ObjectSnapshot& now, const ObjectSnapshot& before,
                                                  const Eigen::Vector3d& start);

}  // namespace mapless
