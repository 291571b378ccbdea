#pragma once

#include <optional>
#include <string>

#include <Eigen/Core>

namespace mapless::inline v1 {

/// Largest element of R R^T - 1 of a rotation. Files often hold rotations of four digits, which deviate by up
/// to 1e-4; a larger deviation comes from another convention or from damage.
inline constexpr double kRotationTolerance = 1e-3;

/// Why R is not a rotation (deviation from orthonormality, determinant), or nothing where it is one.
[[nodiscard]] std::optional<std::string> rotation_problem(const Eigen::Matrix3d& R);

}  // namespace mapless
