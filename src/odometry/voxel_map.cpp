#include "odometry/voxel_map.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include <Eigen/Eigenvalues>

#include "odometry/cube_hash.hpp"

namespace mapless {
namespace {

constexpr std::size_t kNeighbours = 20;
constexpr std::size_t kMinNeighbours = 10;
constexpr std::size_t kFirstCapacity = 1024;

// Moves the nearest kNeighbours to the front, in their order. Selecting among
// bare distances is several times faster than among points.
std::size_t keep_nearest(Eigen::Vector3f* offsets, std::size_t count) {
  if (count <= kNeighbours) return count;
  std::array<float, 8 * VoxelMap::kSlots> squared, sorted;
  for (std::size_t i = 0; i < count; ++i) sorted[i] = squared[i] = offsets[i].squaredNorm();
  std::nth_element(sorted.begin(), sorted.begin() + (kNeighbours - 1), sorted.begin() + count);
  const float farthest = sorted[kNeighbours - 1];
  std::size_t kept = 0;
  for (std::size_t i = 0; i < count && kept < kNeighbours; ++i) {
    if (squared[i] <= farthest) offsets[kept++] = offsets[i];
  }
  return kept;
}

std::optional<MapPlane> fit_plane(const Eigen::Vector3f* offsets, std::size_t count,
                                  const Eigen::Vector3d& q_0) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < count; ++i) mean += offsets[i].cast<double>();
  mean /= static_cast<double>(count);
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < count; ++i) {
    const Eigen::Vector3d d = offsets[i].cast<double>() - mean;
    scatter += d * d.transpose();
  }
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(scatter);
  const Eigen::Vector3d sigma = solver.eigenvalues().cwiseMax(0).cwiseSqrt();
  if (!(sigma.z() > 0)) return std::nullopt;
  return MapPlane{q_0 + mean, solver.eigenvectors().col(0), (sigma.y() - sigma.x()) / sigma.z()};
}

}  // namespace

VoxelMap::VoxelMap(double voxel_m, double spacing_m)
    : voxel_m_(voxel_m), spacing_squared_(static_cast<float>(spacing_m * spacing_m)) {
  rebuild_table(kFirstCapacity);
}

void VoxelMap::clear() {
  voxels_.clear();
  rebuild_table(kFirstCapacity);
}

std::size_t VoxelMap::points() const {
  std::size_t count = 0;
  for (const Voxel& voxel : voxels_) count += static_cast<std::size_t>(voxel.count);
  return count;
}

std::size_t VoxelMap::slot_of(const Eigen::Array3i& corner) const {
  return cube_slot(cube_key(corner), shift_);
}

const VoxelMap::Voxel* VoxelMap::find(const Eigen::Array3i& corner) const {
  const std::size_t mask = table_.size() - 1;
  for (std::size_t slot = slot_of(corner); table_[slot] >= 0; slot = (slot + 1) & mask) {
    const Voxel& voxel = voxels_[static_cast<std::size_t>(table_[slot])];
    if ((voxel.corner == corner).all()) return &voxel;
  }
  return nullptr;
}

VoxelMap::Voxel& VoxelMap::find_or_add(const Eigen::Array3i& corner) {
  const std::size_t mask = table_.size() - 1;
  std::size_t slot = slot_of(corner);
  for (; table_[slot] >= 0; slot = (slot + 1) & mask) {
    Voxel& voxel = voxels_[static_cast<std::size_t>(table_[slot])];
    if ((voxel.corner == corner).all()) return voxel;
  }
  table_[slot] = static_cast<std::int32_t>(voxels_.size());
  voxels_.emplace_back().corner = corner;
  if (2 * voxels_.size() > table_.size()) rebuild_table(2 * table_.size());
  return voxels_.back();
}

void VoxelMap::rebuild_table(std::size_t capacity) {
  table_.assign(capacity, -1);
  shift_ = 64 - std::countr_zero(capacity);
  for (std::size_t i = 0; i < voxels_.size(); ++i) {
    std::size_t slot = slot_of(voxels_[i].corner);
    while (table_[slot] >= 0) slot = (slot + 1) & (capacity - 1);
    table_[slot] = static_cast<std::int32_t>(i);
  }
}

void VoxelMap::insert(const Eigen::Vector3d& p_0) {
  if (!has_cube(p_0, voxel_m_)) return;
  const Eigen::Array3i corner = cube_of(p_0, voxel_m_);
  Voxel& voxel = find_or_add(corner);
  if (voxel.count == kSlots) return;
  const Eigen::Vector3f offset = (p_0 - voxel_m_ * corner.cast<double>().matrix()).cast<float>();
  for (int i = 0; i < voxel.count; ++i) {
    if ((voxel.points[static_cast<std::size_t>(i)] - offset).squaredNorm() < spacing_squared_) return;
  }
  voxel.points[static_cast<std::size_t>(voxel.count++)] = offset;
}

void VoxelMap::keep_within(const Eigen::Vector3d& centre_0, double radius_m) {
  const auto far = [&](const Voxel& voxel) {
    return (voxel_m_ * voxel.corner.cast<double>().matrix() - centre_0).squaredNorm() > radius_m * radius_m;
  };
  voxels_.erase(std::remove_if(voxels_.begin(), voxels_.end(), far), voxels_.end());
  rebuild_table(table_.size());
}

std::optional<MapPlane> VoxelMap::plane_near(const Eigen::Vector3d& q_0) const {
  if (!has_cube(q_0, voxel_m_)) return std::nullopt;
  // The eight cubes whose common corner is the cube corner nearest to the point.
  const Eigen::Array3i low = (q_0 / voxel_m_).array().round().cast<int>() - 1;
  std::array<Eigen::Vector3f, 8 * kSlots> offsets;
  std::size_t count = 0;
  for (int i = 0; i < 8; ++i) {
    const Eigen::Array3i corner = low + Eigen::Array3i(i & 1, i >> 1 & 1, i >> 2);
    const Voxel* voxel = find(corner);
    if (voxel == nullptr) continue;
    const Eigen::Vector3f from_query = (voxel_m_ * corner.cast<double>().matrix() - q_0).cast<float>();
    for (int p = 0; p < voxel->count; ++p)
      offsets[count++] = from_query + voxel->points[static_cast<std::size_t>(p)];
  }
  if (count < kMinNeighbours) return std::nullopt;
  return fit_plane(offsets.data(), keep_nearest(offsets.data(), count), q_0);
}

}  // namespace mapless
