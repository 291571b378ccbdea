#pragma once

#include <optional>
#include <string>

#include <Eigen/Core>

namespace mapless::inline v1 {

/// Rotations are often written with few digits; anything farther from one is another convention, or damage.
inline constexpr double kRotationTolerance = 1e-3;

/// What keeps R from being a rotation, or nothing.
[[nodiscard]] std::optional<std::string> why_no_rotation(const Eigen::Matrix3d& R);

}  // namespace mapless
