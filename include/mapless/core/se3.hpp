#pragma once

/// @file
/// Room core: time, rigid transforms, errors and parameter declarations, on which every other room builds. It
/// depends on no other room and holds no state.

#include <Eigen/Core>

namespace mapless::inline v1 {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// Rigid transform. A variable T_ab maps coordinates in frame b to frame a: p_a = T_ab * p_b.
/// 6-vectors are (translation [m], rotation [rad]); perturbations are on the left: exp(xi^) T
/// (Barfoot, State Estimation for Robotics, chapter 7; method.md section 3).
class SE3 {
 public:
  SE3() : rotation_(Eigen::Matrix3d::Identity()), translation_(Eigen::Vector3d::Zero()) {}
  /// `rotation` must be orthonormal with determinant +1. It is stored unchecked: transforms are made in inner
  /// loops, and readers of files and trajectories check rotations from outside.
  SE3(const Eigen::Matrix3d& rotation, const Eigen::Vector3d& translation)
      : rotation_(rotation), translation_(translation) {}

  [[nodiscard]] static SE3 exp(const Vector6d& xi);
  /// Inverse of exp, with a rotation angle in [0, pi].
  [[nodiscard]] Vector6d log() const;

  [[nodiscard]] const Eigen::Matrix3d& rotation() const { return rotation_; }
  [[nodiscard]] const Eigen::Vector3d& translation() const { return translation_; }
  [[nodiscard]] Eigen::Matrix4d matrix() const;
  [[nodiscard]] SE3 inverse() const;
  /// The same transform with its rotation projected back onto SO(3).
  [[nodiscard]] SE3 normalized() const;

  SE3 operator*(const SE3& other) const {
    return {rotation_ * other.rotation_, rotation_ * other.translation_ + translation_};
  }
  Eigen::Vector3d operator*(const Eigen::Vector3d& p) const { return rotation_ * p + translation_; }

 private:
  Eigen::Matrix3d rotation_;
  Eigen::Vector3d translation_;
};

/// Skew-symmetric matrix: hat(a) b = a x b.
[[nodiscard]] Eigen::Matrix3d hat(const Eigen::Vector3d& a);
/// Rotation by `angle_rad` about +z; a positive angle is counter-clockwise seen from +z.
[[nodiscard]] Eigen::Matrix3d rotation_z(double angle_rad);

/// SO(3) exponential of a rotation vector [rad], and its inverse.
[[nodiscard]] Eigen::Matrix3d so3_exp(const Eigen::Vector3d& phi);
[[nodiscard]] Eigen::Vector3d so3_log(const Eigen::Matrix3d& rotation);

/// Left Jacobian J of SE(3), exp((xi + d)^) ~ exp((J d)^) exp(xi^), and its inverse.
[[nodiscard]] Matrix6d left_jacobian(const Vector6d& xi);
[[nodiscard]] Matrix6d left_jacobian_inverse(const Vector6d& xi);
/// left_jacobian(xi) * v, without the matrix.
[[nodiscard]] Vector6d left_jacobian_times(const Vector6d& xi, const Vector6d& v);

}  // namespace mapless
