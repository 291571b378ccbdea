#include "detection/surface_patches.hpp"

#include <Eigen/Eigenvalues>
#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

#include <mapless/lidar/aligned_image.hpp>

namespace mapless {
namespace {

using Eigen::Matrix3f;
using Eigen::Vector3f;

constexpr std::size_t kFewest = 10;  // points of a plane
// Standard deviations across a plane, and along its shorter side: a row of points and an edge are none.
constexpr float kThickest_m = 0.05F, kNarrowest_m = 0.035F, kThickestPerWidth = 0.5F;

int parts(int whole, int part) { return (whole + part - 1) / part; }

}  // namespace

SurfacePatches::SurfacePatches(const LidarScan& scan, const LocalPoints& points,
                               const std::vector<char>& wanted)
    : across_(parts(scan.columns, kPatchColumns)), down_(parts(scan.rows(), kPatchRows)) {
  gather(scan, wanted);
  patches_.resize(begin_.size() - 1);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, patches_.size(), 64), [&](const auto& part) {
    for (std::size_t p = part.begin(); p != part.end(); ++p) patches_[p] = fitted(points.points, p);
  });
}

void SurfacePatches::gather(const LidarScan& scan, const std::vector<char>& wanted) {
  const AlignedImage image(scan);
  begin_.assign(static_cast<std::size_t>(across_ * down_) + 1, 0);
  std::vector<std::int32_t> patch_of(wanted.size(), -1);
  int laser = -1, shift = 0;
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    if (wanted[i] == 0) continue;
    const LidarReturn& r = scan.returns[i];
    if (r.laser != laser) shift = image.aligned_column(laser = r.laser, 0);
    const int column = r.column + shift < scan.columns ? r.column + shift : r.column + shift - scan.columns;
    patch_of[i] = laser / kPatchRows * across_ + column / kPatchColumns;
    ++begin_[static_cast<std::size_t>(patch_of[i]) + 1];
  }
  for (std::size_t p = 1; p < begin_.size(); ++p) begin_[p] += begin_[p - 1];
  members_.resize(begin_.back());
  std::vector<std::size_t> next(begin_.begin(), begin_.end() - 1);
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    if (wanted[i] != 0)
      members_[next[static_cast<std::size_t>(patch_of[i])]++] = static_cast<std::int32_t>(i);
  }
}

SurfacePatch SurfacePatches::fitted(const std::vector<Vector3f>& points, std::size_t p) const {
  SurfacePatch patch;
  const auto mine = members(p);
  if (mine.size() < kFewest) return patch;
  const auto count = static_cast<float>(mine.size());
  for (const std::int32_t i : mine) patch.centre += points[static_cast<std::size_t>(i)];
  patch.centre /= count;
  Matrix3f squares = Matrix3f::Zero();
  for (const std::int32_t i : mine) {
    const Vector3f d = points[static_cast<std::size_t>(i)] - patch.centre;
    squares += d * d.transpose();
  }
  Eigen::SelfAdjointEigenSolver<Matrix3f> solver;
  solver.computeDirect(squares / count);
  const Vector3f spread = solver.eigenvalues().cwiseMax(0).cwiseSqrt();
  patch.thickness_m = spread.x();
  patch.is_plane =
      spread.x() <= kThickest_m && spread.y() >= kNarrowest_m && spread.x() <= kThickestPerWidth * spread.y();
  patch.normal = solver.eigenvectors().col(0);
  if (patch.normal.dot(patch.centre) > 0) patch.normal = -patch.normal;
  return patch;
}

}  // namespace mapless
