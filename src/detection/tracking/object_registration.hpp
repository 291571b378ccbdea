#pragma once

#include <Eigen/Core>

#include "detection/tracking/object_snapshot.hpp"

namespace mapless::inline v1 {

/// How an object moved from one scan to another.
struct RegisteredMotion {
  Eigen::Vector3d velocity_0 = Eigen::Vector3d::Zero();  ///< of the middle of the earlier view [m/s]
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< [m^2/s^2]; large where the points do not tell
  /// Share of the points that the motion would have where the other scan looked through, plus a little for
  /// their distance from the points of the other view: 0 is best.
  double misfit = 0;
};

/// The velocity at which the points of `now` lie on those of `before`, every point at its own instant, found
/// by descent from `start`. Minimises distances to the planes of `before`, distances of edges across the
/// rays, and, where a neighbourhood is no plane, of points; robustly. A turn rate is estimated along with it,
/// held near 0 by what vehicles do. `now` is later than `before`.
[[nodiscard]] RegisteredMotion register_snapshots(const ObjectSnapshot& now, const ObjectSnapshot& before,
                                                  const Eigen::Vector3d& start);

}  // namespace mapless
