#include "detection/evidence/surface_plane.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

#include <Eigen/Eigenvalues>

namespace mapless::inline v1 {
namespace {

using Eigen::Matrix3f;
using Eigen::Vector3f;

// The returns within this distance make the plane, or within kRadiusSpacings of the rays where these are far
// apart, so that at least two lasers have some. Measured: docs/notebook/detection.md, "Planes at a small
// angle": .3 and .6 m are no better.
constexpr float kRadius_m = 0.4F;
constexpr float kRadiusSpacings = 1.5F;
// Of these at most so many lasers and columns on either side; some columns are left out where there are more.
constexpr int kMaxRows = 6, kMaxColumns = 24, kColumnsTaken = 4;
constexpr int kMinReturns = 5;  // three make a plane, two more show whether it is one

// Flat to within the noise of ranges: standard deviation off the plane, as a share of the tolerance. And
// twice as wide at least; with returns of one laser alone the plane would be that of its rays.
constexpr float kFlat = 0.35F;
constexpr float kWide = 2;

constexpr float kNear = 0.5F;  // of the tolerance: two standard deviations of a range

}  // namespace

float SurfacePlanes::radius_m(const LidarReturn& r) const {
  const double column_rad = 2 * std::numbers::pi / scan_.model->columns;
  const auto spacing = static_cast<float>(std::max(column_rad, scan_.model->elevation_step(r.laser)));
  return std::max(kRadius_m, kRadiusSpacings * spacing * r.range_m);
}

bool SurfacePlanes::contains(std::size_t i, const Vector3f& place) const {
  const Vector3f& p = points_[i];
  if ((place - p).squaredNorm() > kReach_m * kReach_m) return false;
  const Moments around = moments(i, radius_m(scan_.returns[i]));
  if (around.count < kMinReturns || around.count == around.own_laser) return false;
  const auto count = static_cast<float>(around.count);
  const Vector3f mean = around.sum / count;
  Eigen::SelfAdjointEigenSolver<Matrix3f> axes;
  axes.computeDirect(around.squares / count - mean * mean.transpose());
  const float thick2 = axes.eigenvalues()[0];
  if (thick2 > kFlat * kFlat * tolerance_m_ * tolerance_m_) return false;
  if (axes.eigenvalues()[1] < kWide * kWide * thick2) return false;
  return std::abs(axes.eigenvectors().col(0).dot(place - p - mean)) < kNear * tolerance_m_;
}

SurfacePlanes::Moments SurfacePlanes::moments(std::size_t i, float radius_m) const {
  const LidarReturn& r = scan_.returns[i];
  const auto column_m = static_cast<float>(2 * std::numbers::pi / scan_.model->columns) * r.range_m;
  const auto row_m = static_cast<float>(scan_.model->elevation_step(r.laser)) * r.range_m;
  const auto within = [&](float step_m, int least, int most) {
    return std::clamp(static_cast<int>(std::min(radius_m / step_m, static_cast<float>(most))), least, most);
  };
  const int columns = within(column_m, 2, kMaxColumns), rows = within(row_m, 1, kMaxRows);
  const int stride = std::max(columns / kColumnsTaken, 1);
  const int last = std::min(r.laser + rows, scan_.rows() - 1), at = image_.aligned_column(r.laser, r.column);
  Moments around;
  for (int row = std::max(r.laser - rows, 0); row <= last; ++row) {
    for (int c = -columns; c <= columns; c += stride) {
      const std::int32_t j = scan_.cell(row, image_.scan_column(row, at + c));
      if (j < 0) continue;
      const Vector3f d = points_[static_cast<std::size_t>(j)] - points_[i];
      if (d.squaredNorm() > radius_m * radius_m) continue;
      ++around.count;
      around.own_laser += row == r.laser ? 1 : 0;
      around.sum += d;
      around.squares += d * d.transpose();
    }
  }
  return around;
}

}  // namespace mapless
