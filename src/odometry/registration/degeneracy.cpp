#include "odometry/registration/degeneracy.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

namespace mapless::inline v1 {
namespace {

// Weighs rotation against translation where a motion is split into held and free parts.
constexpr double kTypicalRange = 10.0;
// The noise of the normals alone makes a direction look held: it must be held by so many times as much. Not
// by far more: what is held by little errs by little, but what nothing holds from scan to scan runs away.
constexpr double kSpuriousShares = 1.5;

// The perturbation of a bin's pose where the scan's end, and the whole scan with it, is perturbed.
Matrix6d bin_from_end(const BinSums& bin, const SE3& T_v0) { return adjoint(bin.T_v0 * T_v0.inverse()); }

struct WholeScan {
  Matrix6d information = Matrix6d::Zero();
  double weight = 0;
  double spurious = 0;
};

WholeScan whole_scan(const std::vector<BinSums>& sums, const SE3& T_v0) {
  WholeScan out;
  for (const BinSums& bin : sums) {
    if (bin.matched == 0) continue;
    const Matrix6d Ad = bin_from_end(bin, T_v0);
    out.information += Ad.transpose() * bin.information * Ad;
    out.weight += bin.weight;
    out.spurious += bin.spurious;
  }
  return out;
}

// The rotation that follows a unit translation at least cost.
Eigen::Matrix3d following_rotation(const Matrix6d& A) {
  return -A.bottomRightCorner<3, 3>().ldlt().solve(A.bottomLeftCorner<3, 3>());
}

}  // namespace

Degeneracy find_degeneracy(const std::vector<BinSums>& sums, const SE3& T_v0, double min_share) {
  Degeneracy out;
  const auto [A, weight, spurious] = whole_scan(sums, T_v0);
  out.unconstrained = 3;
  if (!(weight > 0)) return out;
  const Eigen::Matrix3d S = A.topLeftCorner<3, 3>() + A.topRightCorner<3, 3>() * following_rotation(A);
  if (!S.allFinite()) return out;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(0.5 * (S + S.transpose()));
  out.constraint_ratio = (solver.eigenvalues() / weight).cwiseMax(0);
  out.directions_v = solver.eigenvectors();
  out.unconstrained = static_cast<int>(
      (out.constraint_ratio.array() < min_share + kSpuriousShares * spurious / weight).count());
  return out;
}

void leave_to_prior(const Degeneracy& degeneracy, const SE3& T_v0, std::vector<BinSums>& sums) {
  if (degeneracy.unconstrained == 0) return;
  const Matrix6d A = whole_scan(sums, T_v0).information;
  const Eigen::Matrix3d rotation = following_rotation(A);
  if (!rotation.allFinite()) return;
  Eigen::Matrix<double, 6, 3> all;
  all << degeneracy.directions_v, rotation * degeneracy.directions_v;
  const Eigen::MatrixXd held = all.leftCols(degeneracy.unconstrained);
  Vector6d scale;
  scale << 1, 1, 1, Eigen::Vector3d::Constant(kTypicalRange * kTypicalRange);
  const Eigen::MatrixXd scaled = scale.asDiagonal() * held;
  const Matrix6d free =
      Matrix6d::Identity() - held * (held.transpose() * scaled).ldlt().solve(scaled.transpose());
  for (BinSums& bin : sums) {
    const Matrix6d Ad = bin_from_end(bin, T_v0);
    const Matrix6d P = Ad * free * adjoint(T_v0 * bin.T_v0.inverse());
    bin.information = (P.transpose() * bin.information * P).eval();
    bin.gradient = (P.transpose() * bin.gradient).eval();
  }
}

}  // namespace mapless
