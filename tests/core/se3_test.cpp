#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include <mapless/core/se3.hpp>

namespace mapless {
namespace MAPLESS_FILE {

constexpr double kPi = std::numbers::pi;

Eigen::Vector3d random_vector(std::mt19937& rng, double scale) {
  std::uniform_real_distribution<double> u(-scale, scale);
  return {u(rng), u(rng), u(rng)};
}

Eigen::Vector3d random_direction(std::mt19937& rng) {
  std::normal_distribution<double> n;
  return Eigen::Vector3d(n(rng), n(rng), n(rng)).normalized();
}

// Rotation angles where closed forms are most likely to fail: 0, both sides of every change of formula, and
// up to pi.
const std::vector<double> kAngles = {0,       1e-12,      1e-8,       0.99e-4,    1.01e-4,    0.99e-2,
                                     1.01e-2, 0.099,      0.101,      0.5,        1.5,        2.5,
                                     3.0,     kPi - 1e-3, kPi - 1e-6, kPi - 1e-8, kPi - 1e-10};

void for_every_case(const std::function<void(const Vector6d&)>& check) {
  for (const double angle : kAngles) {
    for (unsigned seed = 0; seed < 20; ++seed) {
      SCOPED_TRACE(testing::Message() << "angle " << angle << ", seed " << seed);
      std::mt19937 rng(seed);
      Vector6d xi;
      xi << random_vector(rng, seed % 2 == 0 ? 1.0 : 100.0), angle * random_direction(rng);
      check(xi);
    }
  }
}

// exp by its own definition: scaling and squaring of the 4x4 power series.
Eigen::Matrix4d exp_by_series(const Vector6d& xi) {
  Eigen::Matrix4d A = Eigen::Matrix4d::Zero();
  A.topLeftCorner<3, 3>() = hat(xi.tail<3>());
  A.topRightCorner<3, 1>() = xi.head<3>();
  A /= 1024;
  Eigen::Matrix4d sum = Eigen::Matrix4d::Identity(), term = Eigen::Matrix4d::Identity();
  for (int i = 1; i < 12; ++i) {
    term = term * A / i;
    sum += term;
  }
  for (int i = 0; i < 10; ++i) sum = (sum * sum).eval();
  return sum;
}

// J = sum of (xi^curly)^n / (n + 1)! (Barfoot, equation 7.83).
Matrix6d left_jacobian_by_series(const Vector6d& xi) {
  Matrix6d curly = Matrix6d::Zero();
  curly.topLeftCorner<3, 3>() = hat(xi.tail<3>());
  curly.bottomRightCorner<3, 3>() = hat(xi.tail<3>());
  curly.topRightCorner<3, 3>() = hat(xi.head<3>());
  Matrix6d sum = Matrix6d::Identity(), term = Matrix6d::Identity();
  for (int n = 1; n < 60; ++n) {
    term = term * curly / (n + 1);
    sum += term;
  }
  return sum;
}

double scale_of(const Vector6d& xi) { return 1 + xi.head<3>().norm(); }

TEST(Se3, HatIsTheCrossProduct) {
  std::mt19937 rng(1);
  for (int i = 0; i < 10; ++i) {
    const Eigen::Vector3d a = random_vector(rng, 1), b = random_vector(rng, 1);
    EXPECT_LT((hat(a) * b - a.cross(b)).norm(), 1e-15);
  }
}

TEST(Se3, RotationZTurnsCounterClockwise) {
  const Eigen::Vector3d p = rotation_z(kPi / 2) * Eigen::Vector3d(2, 0, 5);
  EXPECT_LT((p - Eigen::Vector3d(0, 2, 5)).norm(), 1e-15);
  EXPECT_LT((rotation_z(0.7) - so3_exp({0, 0, 0.7})).norm(), 1e-15);
}

TEST(Se3, ExpIsTheMatrixExponential) {
  for_every_case([](const Vector6d& xi) {
    const SE3 T = SE3::exp(xi);
    EXPECT_LT((T.matrix() - exp_by_series(xi)).norm(), 5e-12 * scale_of(xi));
    EXPECT_LT((T.rotation() * T.rotation().transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-14);
    EXPECT_NEAR(T.rotation().determinant(), 1, 1e-14);
  });
}

TEST(Se3, LogInvertsExp) {
  for_every_case(
      [](const Vector6d& xi) { EXPECT_LT((SE3::exp(xi).log() - xi).norm(), 1e-13 * scale_of(xi)); });
}

TEST(Se3, ExpInvertsLogOfAHalfTurn) {
  for (unsigned seed = 0; seed < 50; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 rng(seed);
    const Eigen::Vector3d axis = seed < 3 ? Eigen::Vector3d::Unit(seed) : random_direction(rng);
    // A turn by pi is 2 a a^T - 1, whichever sign its axis has.
    const SE3 T(2 * axis * axis.transpose() - Eigen::Matrix3d::Identity(), random_vector(rng, 10));
    const Vector6d xi = T.log();
    EXPECT_NEAR(xi.tail<3>().norm(), kPi, 1e-14);
    EXPECT_LT((SE3::exp(xi).matrix() - T.matrix()).norm(), 1e-12);
  }
}

TEST(Se3, LogHasAnAngleOfAtMostPi) {
  const Eigen::Vector3d phi = so3_log(so3_exp({0, 0, kPi + 0.1}));
  EXPECT_LT((phi - Eigen::Vector3d(0, 0, -kPi + 0.1)).norm(), 1e-14);
}

TEST(Se3, InverseAndProduct) {
  for_every_case([](const Vector6d& xi) {
    const SE3 T = SE3::exp(xi), S = SE3::exp(Vector6d::LinSpaced(0.1, 0.6));
    EXPECT_LT((T.inverse().matrix() - SE3::exp(-xi).matrix()).norm(), 1e-13 * scale_of(xi));
    EXPECT_LT(((T * T.inverse()).matrix() - Eigen::Matrix4d::Identity()).norm(), 1e-13 * scale_of(xi));
    EXPECT_LT(((T * S).matrix() - T.matrix() * S.matrix()).norm(), 1e-13 * scale_of(xi));
    const Eigen::Vector3d p(1, 2, 3);
    EXPECT_LT((T * p - (T.matrix() * p.homogeneous()).head<3>()).norm(), 1e-13 * scale_of(xi));
  });
}

TEST(Se3, LeftJacobianEqualsItsPowerSeries) {
  for_every_case([](const Vector6d& xi) {
    EXPECT_LT((left_jacobian(xi) - left_jacobian_by_series(xi)).norm(), 1e-12 * scale_of(xi));
  });
}

TEST(Se3, LeftJacobianIsTheDerivativeOfExp) {
  for_every_case([](const Vector6d& xi) {
    constexpr double h = 1e-5;
    Matrix6d numeric;
    for (int i = 0; i < 6; ++i) {
      const Vector6d d = h * Vector6d::Unit(i);
      const SE3 T_inverse = SE3::exp(xi).inverse();
      numeric.col(i) =
          ((SE3::exp(xi + d) * T_inverse).log() - (SE3::exp(xi - d) * T_inverse).log()) / (2 * h);
    }
    EXPECT_LT((left_jacobian(xi) - numeric).norm(), 2e-9 * scale_of(xi));
  });
}

TEST(Se3, LeftJacobianInverseIsItsInverse) {
  for_every_case([](const Vector6d& xi) {
    EXPECT_LT((left_jacobian(xi) * left_jacobian_inverse(xi) - Matrix6d::Identity()).norm(),
              1e-12 * scale_of(xi));
  });
}

TEST(Se3, LeftJacobianTimesAVectorIsTheirProduct) {
  for_every_case([](const Vector6d& xi) {
    const Vector6d v = (Vector6d() << 1, -2, 3, -0.4, 0.5, 0.6).finished();
    EXPECT_LT((left_jacobian_times(xi, v) - left_jacobian(xi) * v).norm(), 1e-13 * scale_of(xi));
  });
}

TEST(Se3, NormalizedRemovesDrift) {
  std::mt19937 rng(5);
  const SE3 T = SE3::exp((Vector6d() << 1, 2, 3, 0.3, -0.2, 1.1).finished());
  const SE3 drifted(T.rotation() + 1e-6 * Eigen::Matrix3d::Random(), T.translation());
  const Eigen::Matrix3d R = drifted.normalized().rotation();
  EXPECT_LT((R * R.transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-14);
  EXPECT_LT((R - T.rotation()).norm(), 5e-6);
  EXPECT_EQ(drifted.normalized().translation(), T.translation());
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
