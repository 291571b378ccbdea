#include <cmath>
#include <limits>

#include <mapless/geometry/compensated_scan.hpp>

namespace mapless::inline v1 {
namespace {

// Three numbers of 21 bits fit into one of 64.
constexpr unsigned kBits = 21;
constexpr double kReach_voxels = 1U << (kBits - 1);

// Of the voxel of a point, by its place from the origin; none beyond the reach.
std::optional<std::uint64_t> key_of(const Eigen::Vector3d& from_origin, double edge_m) {
  std::uint64_t key = 0;
  for (const double v : from_origin) {
    const double cell = std::floor(v / edge_m) + kReach_voxels;
    if (!(cell >= 0 && cell < 2 * kReach_voxels)) return std::nullopt;
    key = key << kBits | static_cast<std::uint64_t>(cell);
  }
  return key;
}

}  // namespace

VoxelMap::VoxelMap(double edge_m, std::optional<std::size_t> max_voxels)
    : edge_m_(edge_m), max_voxels_(max_voxels.value_or(std::numeric_limits<std::size_t>::max())) {
  // A map that grows while clouds arrive must not stop to rehash millions of voxels.
  if (max_voxels) index_.reserve(*max_voxels);
  if (max_voxels) voxels_.reserve(*max_voxels);
}

bool VoxelMap::add(const Eigen::Vector3d& point_0) {
  if (!origin_0_) origin_0_ = point_0;
  const Eigen::Vector3d from_origin = point_0 - *origin_0_;
  const std::optional<std::uint64_t> key = key_of(from_origin, edge_m_);
  if (!key) return false;
  auto found = index_.find(*key);
  if (found == index_.end()) {
    if (voxels_.size() >= max_voxels_) return false;
    found = index_.emplace(*key, voxels_.size()).first;
    voxels_.emplace_back();
  }
  Voxel& voxel = voxels_[found->second];
  voxel.sum += from_origin;
  ++voxel.points;
  return true;
}

ExportCloud VoxelMap::cloud() const {
  ExportCloud out;
  out.columns.push_back({"points", {}});
  out.points.reserve(size());
  out.columns.front().values.reserve(size());
  for (const Voxel& voxel : voxels_) {
    out.points.emplace_back(*origin_0_ + voxel.sum / voxel.points);
    out.columns.front().values.push_back(voxel.points);
  }
  return out;
}

}  // namespace mapless
