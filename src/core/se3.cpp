#include <cmath>

#include <Eigen/Geometry>

#include <mapless/core/se3.hpp>

namespace mapless::inline v1 {
namespace {

// Below these angles [rad] the closed forms lose digits to cancellation. The series used there are exact to
// double precision: the first term left out is below 1e-16 of the sum at the bound.
constexpr double kSmallAngle = 1e-2;
constexpr double kSmallAngleOfBlockQ = 0.1;

// sin(x)/x, (1 - cos x)/x^2, (x - sin x)/x^3
struct AngleTerms {
  double a, b, c;
};

AngleTerms angle_terms(double x) {
  const double x2 = x * x;
  if (x < kSmallAngle) {
    return {1 - x2 / 6 * (1 - x2 / 20 * (1 - x2 / 42)), 0.5 - x2 / 24 * (1 - x2 / 30 * (1 - x2 / 56)),
            1.0 / 6 - x2 / 120 * (1 - x2 / 42 * (1 - x2 / 72))};
  }
  const double half_sine = std::sin(x / 2);
  return {std::sin(x) / x, 2 * half_sine * half_sine / x2, (x - std::sin(x)) / (x2 * x)};
}

Eigen::Matrix3d so3_left_jacobian(const Eigen::Vector3d& phi) {
  const AngleTerms k = angle_terms(phi.norm());
  const Eigen::Matrix3d W = hat(phi);
  return Eigen::Matrix3d::Identity() + k.b * W + k.c * W * W;
}

Eigen::Matrix3d so3_left_jacobian_inverse(const Eigen::Vector3d& phi) {
  const double x = phi.norm();
  const Eigen::Matrix3d W = hat(phi);
  const double x2 = x * x;
  // tan(x / 2) keeps its digits up to pi, where sin(x) has none left.
  const double k =
      x < kSmallAngle ? 1.0 / 12 + x2 / 720 * (1 + x2 / 42) : (1 - x / (2 * std::tan(x / 2))) / x2;
  return Eigen::Matrix3d::Identity() - 0.5 * W + k * W * W;
}

// Weights of the products in the translation-rotation block Q of the left Jacobian (Barfoot, equation 7.86b).
struct BlockTerms {
  double m2, m3, m4;
};

BlockTerms block_terms(double x) {
  const double x2 = x * x;
  if (x < kSmallAngleOfBlockQ) {
    return {1.0 / 6 - x2 / 120 * (1 - x2 / 42 * (1 - x2 / 72 * (1 - x2 / 110))),
            1.0 / 24 - x2 / 720 * (1 - x2 / 56 * (1 - x2 / 90 * (1 - x2 / 132))),
            1.0 / 120 - x2 / 2520 * (1 - x2 / 48 * (1 - 2 * x2 / 165))};
  }
  return {(x - std::sin(x)) / (x2 * x), (x2 / 2 + std::cos(x) - 1) / (x2 * x2),
          (2 * x - 3 * std::sin(x) + x * std::cos(x)) / (2 * x2 * x2 * x)};
}

Eigen::Matrix3d jacobian_block_q(const Vector6d& xi) {
  const Eigen::Matrix3d P = hat(xi.head<3>());
  const Eigen::Matrix3d W = hat(xi.tail<3>());
  const auto [m2, m3, m4] = block_terms(xi.tail<3>().norm());
  return 0.5 * P + m2 * (W * P + P * W + W * P * W) + m3 * (W * W * P + P * W * W - 3 * W * P * W) +
         m4 * (W * P * W * W + W * W * P * W);
}

}  // namespace

Eigen::Matrix3d hat(const Eigen::Vector3d& a) {
  Eigen::Matrix3d W;
  W << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return W;
}

Eigen::Matrix3d rotation_z(double angle_rad) {
  const double c = std::cos(angle_rad), s = std::sin(angle_rad);
  Eigen::Matrix3d R;
  R << c, -s, 0, s, c, 0, 0, 0, 1;
  return R;
}

Eigen::Matrix3d so3_exp(const Eigen::Vector3d& phi) {
  const AngleTerms k = angle_terms(phi.norm());
  const Eigen::Matrix3d W = hat(phi);
  return Eigen::Matrix3d::Identity() + k.a * W + k.b * W * W;
}

Eigen::Vector3d so3_log(const Eigen::Matrix3d& rotation) {
  // Through the quaternion, which stays well conditioned up to an angle of pi.
  Eigen::Quaterniond q(rotation);
  if (q.w() < 0) q.coeffs() = -q.coeffs();
  const double s = q.vec().norm();
  constexpr double kNoRotation = 1e-12;  // half angle [rad] at which atan2(s, w) / s is 1 to double precision
  const double scale = s < kNoRotation ? 2 / q.w() : 2 * std::atan2(s, q.w()) / s;
  return scale * q.vec();
}

SE3 SE3::exp(const Vector6d& xi) {
  const Eigen::Vector3d rho = xi.head<3>(), phi = xi.tail<3>();
  const AngleTerms k = angle_terms(phi.norm());
  const Eigen::Vector3d turned = phi.cross(rho);
  // I + a W + b W W element by element: evaluated for every column of every scan.
  const double x = phi.x(), y = phi.y(), z = phi.z();
  const double bx = k.b * x, by = k.b * y, bz = k.b * z;
  Eigen::Matrix3d rotation;
  rotation << 1 - by * y - bz * z, bx * y - k.a * z, bx * z + k.a * y,  //
      bx * y + k.a * z, 1 - bx * x - bz * z, by * z - k.a * x,          //
      bx * z - k.a * y, by * z + k.a * x, 1 - bx * x - by * y;
  return {rotation, rho + k.b * turned + k.c * phi.cross(turned)};
}

Vector6d SE3::log() const {
  Vector6d xi;
  xi.tail<3>() = so3_log(rotation_);
  xi.head<3>() = so3_left_jacobian_inverse(xi.tail<3>()) * translation_;
  return xi;
}

Eigen::Matrix4d SE3::matrix() const {
  Eigen::Matrix4d T = Eigen::Matrix4d::Identity();
  T.topLeftCorner<3, 3>() = rotation_;
  T.topRightCorner<3, 1>() = translation_;
  return T;
}

SE3 SE3::inverse() const {
  const Eigen::Matrix3d C = rotation_.transpose();
  return {C, -(C * translation_)};
}

SE3 SE3::normalized() const {
  return {Eigen::Quaterniond(rotation_).normalized().toRotationMatrix(), translation_};
}

Matrix6d left_jacobian(const Vector6d& xi) {
  const Eigen::Matrix3d J = so3_left_jacobian(xi.tail<3>());
  Matrix6d out = Matrix6d::Zero();
  out.topLeftCorner<3, 3>() = J;
  out.bottomRightCorner<3, 3>() = J;
  out.topRightCorner<3, 3>() = jacobian_block_q(xi);
  return out;
}

Vector6d left_jacobian_times(const Vector6d& xi, const Vector6d& v) {
  const Eigen::Vector3d rho = xi.head<3>(), phi = xi.tail<3>();
  const double x = phi.norm();
  const AngleTerms k = angle_terms(x);
  const auto [m2, m3, m4] = block_terms(x);
  const auto P = [&](const Eigen::Vector3d& a) { return rho.cross(a).eval(); };
  const auto W = [&](const Eigen::Vector3d& a) { return phi.cross(a).eval(); };
  const Eigen::Vector3d w = v.tail<3>();
  const Eigen::Vector3d Pw = P(w), Ww = W(w), WWw = W(Ww), WPw = W(Pw), PWw = P(Ww), WPWw = W(PWw),
                        PWWw = P(WWw);
  const Eigen::Vector3d Wt = W(v.head<3>());
  Vector6d out;
  out.head<3>() = v.head<3>() + k.b * Wt + k.c * W(Wt) + 0.5 * Pw + m2 * (WPw + PWw + WPWw) +
                  m3 * (W(WPw) + PWWw - 3 * WPWw) + m4 * (W(PWWw) + W(WPWw));
  out.tail<3>() = w + k.b * Ww + k.c * WWw;
  return out;
}

Matrix6d left_jacobian_inverse(const Vector6d& xi) {
  const Eigen::Matrix3d Ji = so3_left_jacobian_inverse(xi.tail<3>());
  Matrix6d out = Matrix6d::Zero();
  out.topLeftCorner<3, 3>() = Ji;
  out.bottomRightCorner<3, 3>() = Ji;
  out.topRightCorner<3, 3>() = -Ji * jacobian_block_q(xi) * Ji;
  return out;
}

}  // namespace mapless
