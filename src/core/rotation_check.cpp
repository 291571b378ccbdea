#include "core/rotation_check.hpp"

#include <Eigen/LU>
#include <fmt/format.h>

namespace mapless::inline v1 {

std::optional<std::string> rotation_problem(const Eigen::Matrix3d& R) {
  const double deviation = (R * R.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (deviation <= kRotationTolerance && R.determinant() > 0) return std::nullopt;
  return fmt::format("is not a rotation: R R^T differs from 1 by {:.3g}, the determinant is {:.3g}",
                     deviation, R.determinant());
}

}  // namespace mapless
