#pragma once

#include <vector>

#include <Eigen/Core>

namespace mapless::test {

/// A plane through points as least squares says, with every point kept and the decomposition done in full.
struct OraclePlane {
  Eigen::Vector3d mean, normal, middle, largest;
  Eigen::Vector3d extent;  ///< mean squares along normal, middle and largest
};

[[nodiscard]] OraclePlane plane_through(const std::vector<Eigen::Vector3d>& points);

/// Variance of the distance at q of a point from the plane, where noise of variance `expected` counts like
/// `weight` points: thickness + thickness / n (1 + d_middle^2 / extent_middle + d_largest^2 /
/// extent_largest).
[[nodiscard]] double variance_at(const OraclePlane& plane, std::size_t count, double expected, double weight,
                                 const Eigen::Vector3d& q);

}  // namespace mapless::test
