#include "detection/evidence/surface_planes.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

namespace mapless::inline v1 {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

// The returns within this distance make the plane, or within kRadiusSpacings of the rays where these are far
// apart, so that at least two lasers have some. Measured: docs/notebook/detection.md, "Planes at a small
// angle": .2 to .6 m give the same.
constexpr float kRadius_m = 0.4F;
constexpr float kRadiusSpacings = 1.5F;
// Of these at most so many lasers and columns on either side; some columns are left out where there are more.
constexpr int kMaxRows = 6, kMaxColumns = 24, kColumnsTaken = 4;
// Three returns make a plane, two more show whether it is one; it is at least twice as wide as thick.
constexpr PlaneLimits kPlane = {5, 0.5, 0};
// Flat to within the noise of ranges: standard deviation off the plane, as a share of the tolerance.
constexpr double kFlat = 0.35;
constexpr double kNear = 0.5;  // of the tolerance: two standard deviations of a range

}  // namespace

float SurfacePlanes::radius_m(const LidarReturn& r) const {
  const double column_rad = 2 * std::numbers::pi / scan_.model->columns;
  const auto spacing = static_cast<float>(std::max(column_rad, scan_.model->elevation_step(r.laser)));
  return std::max(kRadius_m, kRadiusSpacings * spacing * r.range_m);
}

bool SurfacePlanes::contains(std::size_t i, const Vector3f& place) const {
  const Vector3f to_place = place - points_[i];
  if (to_place.squaredNorm() > kReach_m * kReach_m) return false;
  // The plane of returns of one laser would be that of its rays.
  const auto [moments, other_lasers] = around(i);
  if (!other_lasers) return false;
  const auto normal = plane_normal(moments, kPlane);
  if (!normal) return false;
  const double flat_m = kFlat * static_cast<double>(tolerance_m_);
  if (normal->dot(moments.covariance() * *normal) > flat_m * flat_m) return false;
  const Vector3d to_plane = moments.sum / moments.count;
  return std::abs(normal->dot(to_place.cast<double>() - to_plane)) <
         kNear * static_cast<double>(tolerance_m_);
}

SurfacePlanes::Surroundings SurfacePlanes::around(std::size_t i) const {
  const LidarReturn& r = scan_.returns[i];
  const float radius = radius_m(r);
  const auto column_m = static_cast<float>(2 * std::numbers::pi / scan_.model->columns) * r.range_m;
  const auto row_m = static_cast<float>(scan_.model->elevation_step(r.laser)) * r.range_m;
  const auto within = [&](float step_m, int least, int most) {
    return std::clamp(static_cast<int>(std::min(radius / step_m, static_cast<float>(most))), least, most);
  };
  const int columns = within(column_m, 2, kMaxColumns), rows = within(row_m, 1, kMaxRows);
  const int stride = std::max(columns / kColumnsTaken, 1);
  const int last = std::min(r.laser + rows, scan_.rows() - 1), at = image_.aligned_column(r.laser, r.column);
  Surroundings out;
  for (int row = std::max(r.laser - rows, 0); row <= last; ++row) {
    for (int c = -columns; c <= columns; c += stride) {
      const std::int32_t j = scan_.cell(row, image_.scan_column(row, at + c));
      if (j < 0) continue;
      const Vector3f d = points_[static_cast<std::size_t>(j)] - points_[i];
      if (d.squaredNorm() > radius * radius) continue;
      out.moments.add(d.cast<double>());
      out.other_lasers = out.other_lasers || row != r.laser;
    }
  }
  return out;
}

}  // namespace mapless
