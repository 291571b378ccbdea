#include "detection/tracking/slow_motion.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

namespace mapless::inline v1 {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Standard deviation of the end of a ray off a plane: range noise of both (sqrt(2) x 0.02 m).
constexpr double kRayStd_m = 0.03;
// Scales of the Cauchy weight, from coarse to fine: the first is about the way of something that does not
// count as slow, the last holds the ends on the same surface.
constexpr std::array<double, 4> kScales_m = {0.1, 0.1, 0.05, 0.05};
// Normals err by 10 degrees (0.03 m over 0.16 m): sin^2 of that is the share of its information that a plane
// seems to have along itself. Measured: with a third of it buses alongside stop, with three times nobody
// does.
constexpr double kTiltedInformation = 0.03;
// Information of a direction that nothing constrains [s^2/m^2]: a standard deviation of 30 m/s.
constexpr double kLeastInformation = 1e-3;

// Neighbours lie this far away: much more than the range noise, less than a limb is wide.
constexpr double kNeighbour_m = 0.08;
constexpr int kLeastColumns = 2;  // noise of neighbouring firings would turn the normal
// A neighbour deeper by more than this share of its distance across the ray is beyond an edge.
constexpr double kSteepest = 1.5;

}  // namespace

SlowMotion slow_motion(std::span<const PlaneOffset> offsets) {
  Vector3d velocity = Vector3d::Zero();
  Matrix3d information;
  for (const double scale_m : kScales_m) {
    information = kLeastInformation * Matrix3d::Identity();
    Vector3d moment = Vector3d::Zero();
    for (const PlaneOffset& offset : offsets) {
      const double residual_m = offset.off_m + offset.before_s * offset.normal_0.dot(velocity);
      const double ratio = residual_m / scale_m;
      const Vector3d J = offset.before_s / kRayStd_m * offset.normal_0;
      const double weight = 1 / (1 + ratio * ratio);
      information += weight * J * J.transpose();
      moment -= weight * residual_m / kRayStd_m * J;
    }
    velocity += information.ldlt().solve(moment);
  }
  const Vector3d known =
      Eigen::SelfAdjointEigenSolver<Matrix3d>(information, Eigen::EigenvaluesOnly).eigenvalues();
  return {velocity, 1 / std::sqrt(std::max(known[0] - kTiltedInformation * known[2], kLeastInformation))};
}

SurfaceNormals::SurfaceNormals(const LidarScan& scan, const std::vector<Eigen::Vector3f>& points)
    : scan_(scan),
      points_(points),
      image_(scan),
      row_rad_(scan.rows() < 2 ? std::numbers::pi : scan.model->mean_elevation_step()),
      column_rad_(2 * std::numbers::pi / scan.model->columns) {}

Vector3d SurfaceNormals::of(std::size_t i) const {
  const double range_m = scan_.returns[i].range_m;
  const auto steps = [&](double step_rad) {
    return static_cast<int>(std::min(std::lround(kNeighbour_m / (range_m * step_rad)), long{scan_.columns}));
  };
  const Vector3d up = across(i, std::max(steps(row_rad_), 1), 0);
  const Vector3d left = across(i, 0, std::max(steps(column_rad_), kLeastColumns));
  const Vector3d normal = up.cross(left);
  return normal.isZero(0) ? normal : normal.normalized();
}

// From the neighbour on one side to that on the other; from or to the point where one is missing.
Vector3d SurfaceNormals::across(std::size_t i, int rows, int columns) const {
  const LidarReturn& r = scan_.returns[i];
  Vector3d sum = Vector3d::Zero();
  for (const int side : {-1, 1}) {
    const int row = r.laser + side * rows;
    if (row < 0 || row >= scan_.rows()) continue;
    const int column = image_.scan_column(row, image_.aligned_column(r.laser, r.column) + side * columns);
    const std::int32_t n = scan_.cell(row, column);
    if (n < 0) continue;
    const auto j = static_cast<std::size_t>(n);
    const Vector3d to = (points_[j] - points_[i]).cast<double>();
    const double deeper_m = std::abs(static_cast<double>(scan_.returns[j].range_m - r.range_m));
    const double across2 = to.squaredNorm() - deeper_m * deeper_m;
    if (deeper_m * deeper_m < kSteepest * kSteepest * across2) sum += side * to;
  }
  return sum;
}

}  // namespace mapless
