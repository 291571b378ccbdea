#include "odometry/registration/degeneracy.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

namespace mapless::inline v1 {
namespace {

// Weighs rotation [rad] against translation [m] where a motion is split into constrained and unconstrained
// parts. Chosen: the typical range of a keypoint; a rotation moves a point by angle x range.
constexpr double kTypicalRange_m = 10.0;
// The noise of the normals alone makes a direction look constrained, by about `normal_noise / weight`; a
// direction must exceed this by the factor. Measured with 3 and 1.5 on flying sensors (OS1-128, seeds 801,
// 802 and 805): with 3, a weakly constrained direction was left to the prior scan after scan and its speed
// diverged; with 1.5 none errs by 0.02 m per scan (docs/notebook/odometry.md, "What is left to the prior").
constexpr double kNormalNoiseFactor = 1.5;
constexpr double kWeakConstraintRatio = 0.003;

// Maps a perturbation of the scan's end, the whole scan moving rigidly with it, to that of a bin's pose.
Matrix6d bin_from_end(const BinSums& bin, const SE3& T_v0) { return adjoint(bin.T_v0 * T_v0.inverse()); }

struct WholeScan {
  Matrix6d information = Matrix6d::Zero();
  double weight = 0;
  double normal_noise = 0;
};

WholeScan whole_scan(const std::vector<BinSums>& sums, const SE3& T_v0) {
  WholeScan out;
  for (const BinSums& bin : sums) {
    if (bin.inliers == 0) continue;
    const Matrix6d Ad = bin_from_end(bin, T_v0);
    out.information += Ad.transpose() * bin.information * Ad;
    out.weight += bin.weight;
    out.normal_noise += bin.normal_noise;
  }
  return out;
}

// Maps a translation to the rotation that minimises the cost with it.
Eigen::Matrix3d following_rotation(const Matrix6d& A) {
  return -A.bottomRightCorner<3, 3>().ldlt().solve(A.bottomLeftCorner<3, 3>());
}

}  // namespace

Degeneracy find_degeneracy(const std::vector<BinSums>& sums, const SE3& T_v0, double min_ratio) {
  Degeneracy out;
  const auto [A, weight, normal_noise] = whole_scan(sums, T_v0);
  out.unconstrained = 3;
  if (!(weight > 0)) return out;
  const Eigen::Matrix3d S = A.topLeftCorner<3, 3>() + A.topRightCorner<3, 3>() * following_rotation(A);
  if (!S.allFinite()) return out;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(0.5 * (S + S.transpose()));
  out.constraint_ratio = (solver.eigenvalues() / weight).cwiseMax(0);
  out.directions_v = solver.eigenvectors();
  out.unconstrained = static_cast<int>(
      (out.constraint_ratio.array() < min_ratio + kNormalNoiseFactor * normal_noise / weight).count());
  return out;
}

void project_out_unconstrained(const Degeneracy& degeneracy, const SE3& T_v0, std::vector<BinSums>& sums) {
  if (degeneracy.unconstrained == 0) return;
  const Matrix6d A = whole_scan(sums, T_v0).information;
  const Eigen::Matrix3d rotation = following_rotation(A);
  if (!rotation.allFinite()) return;
  Eigen::Matrix<double, 6, 3> all;
  all << degeneracy.directions_v, rotation * degeneracy.directions_v;
  const Eigen::MatrixXd register_at_speed = all.leftCols(degeneracy.unconstrained);
  Vector6d scale;
  scale << 1, 1, 1, Eigen::Vector3d::Constant(kTypicalRange_m * kTypicalRange_m);
  const Eigen::MatrixXd scaled = scale.asDiagonal() * register_at_speed;
  const Matrix6d free =
      Matrix6d::Identity() -
      register_at_speed * (register_at_speed.transpose() * scaled).ldlt().solve(scaled.transpose());
  for (BinSums& bin : sums) {
    const Matrix6d Ad = bin_from_end(bin, T_v0);
    const Matrix6d P = Ad * free * adjoint(T_v0 * bin.T_v0.inverse());
    bin.information = (P.transpose() * bin.information * P).eval();
    bin.gradient = (P.transpose() * bin.gradient).eval();
  }
}

bool is_weak(const Degeneracy& degeneracy) { return degeneracy.constraint_ratio[0] < kWeakConstraintRatio; }

}  // namespace mapless
