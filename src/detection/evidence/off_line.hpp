#pragma once

#include <algorithm>

#include <Eigen/Core>

namespace mapless::inline v1 {

/// Squared distance of a point from the line through a and b, or from the nearer of the two beyond them.
inline float off_line2(const Eigen::Vector3f& q, const Eigen::Vector3f& a, const Eigen::Vector3f& b) {
  const Eigen::Vector3f chord = b - a;
  const float length2 = chord.squaredNorm();
  const float along = length2 > 0 ? std::clamp(chord.dot(q - a) / length2, 0.0F, 1.0F) : 0;
  return (q - a - along * chord).squaredNorm();
}

}  // namespace mapless
