#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace mapless::inline v1 {

/// Number, sum and sum of squares of points relative to a reference near them: world coordinates of
/// kilometres then cost no digits.
struct Moments {
  double count = 0;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();

  void add(const Eigen::Vector3d& d) {
    ++count;
    sum += d;
    squares.noalias() += d * d.transpose();
  }
  [[nodiscard]] Eigen::Matrix3d covariance() const {
    const Eigen::Vector3d mean = sum / count;
    return squares / count - mean * mean.transpose();
  }
};

/// Eigenvalues of a covariance over its trace, by increasing size.
struct RelativeVariances {
  double smallest, middle, largest;
};

/// `a`: a symmetric matrix of trace 1 without negative eigenvalues. The smallest one is the lowest root of
/// its characteristic polynomial, which Newton's method approaches from 0 without passing it, as the
/// polynomial rises and bends down before it; the other two then solve a quadratic equation. That is as
/// accurate as needed where the smallest eigenvalue is well separated; else there is no plane.
inline RelativeVariances relative_variances(const Eigen::Matrix3d& a) {
  // A plane's smallest variance converges quadratically; equal eigenvalues halve the error at each step.
  constexpr int kMaxIterations = 30;
  constexpr double kConverged = 1e-10;  // of the trace
  const double minors = a(0, 0) * a(1, 1) - a(0, 1) * a(0, 1) + a(0, 0) * a(2, 2) - a(0, 2) * a(0, 2) +
                        a(1, 1) * a(2, 2) - a(1, 2) * a(1, 2);
  if (minors <= 0) return {0, 0, 1};
  const double determinant = a.determinant();
  double x = 0;
  for (int i = 0; i < kMaxIterations; ++i) {
    const double slope = (3 * x - 2) * x + minors;
    const double value = ((x - 1) * x + minors) * x - determinant;
    if (slope <= 0 || value >= -kConverged * slope) break;
    x -= value / slope;
  }
  const double sum = 1 - x, product = std::max(minors - x * sum, 0.0);
  const double largest = (sum + std::sqrt(std::max(sum * sum - 4 * product, 0.0))) / 2;
  return {x, product / largest, largest};
}

/// What points on a plane are, as in NormalParameters.
struct PlaneLimits {
  int min_points;
  double max_thickness_ratio, min_width_ratio;
};

/// Unit normal, of either sign, of the plane through the points, if they lie on a plane.
inline std::optional<Eigen::Vector3d> plane_normal(const Moments& moments, const PlaneLimits& limits) {
  // Below this share of the largest variance the middle one is rounding error, not width: single precision
  // has moments to 1e-7.
  constexpr double kRounding = 1e-6;
  if (moments.count < limits.min_points) return std::nullopt;
  Eigen::Matrix3d a = moments.covariance();
  const double trace = a.trace();
  if (!(trace > 0)) return std::nullopt;
  a /= trace;
  const RelativeVariances variances = relative_variances(a);
  const double thickness = limits.max_thickness_ratio * limits.max_thickness_ratio;
  const double width = std::max(limits.min_width_ratio * limits.min_width_ratio, kRounding);
  if (variances.middle < width * variances.largest) return std::nullopt;
  if (variances.smallest > thickness * variances.middle) return std::nullopt;
  // The rows of a - smallest I span the plane; the longest of their cross products is the most accurate.
  a.diagonal().array() -= variances.smallest;
  Eigen::Vector3d normal = a.col(0).cross(a.col(1));
  for (const Eigen::Vector3d& other : {a.col(0).cross(a.col(2)).eval(), a.col(1).cross(a.col(2)).eval()}) {
    if (other.squaredNorm() > normal.squaredNorm()) normal = other;
  }
  return normal.normalized();
}

}  // namespace mapless
