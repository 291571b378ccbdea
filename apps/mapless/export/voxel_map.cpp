#include "export/voxel_map.hpp"

#include <cmath>

#include <fmt/format.h>

#include <mapless/core/errors.hpp>

namespace mapless::app {
namespace {

// Three numbers of 21 bits fit into one of 64.
constexpr unsigned kBits = 21;
constexpr double kReach_voxels = 1U << (kBits - 1);

}  // namespace

void VoxelMap::add(const Eigen::Vector3d& point_0) {
  if (!origin_0_) origin_0_ = point_0;
  const Eigen::Vector3d from_origin = point_0 - *origin_0_;
  std::uint64_t key = 0;
  for (const double v : from_origin) {
    const double cell = std::floor(v / edge_m_) + kReach_voxels;
    if (!(cell >= 0 && cell < 2 * kReach_voxels)) {
      throw InputError({"trajectory", "", fmt::format("{:.0f} m", v),
                        "is too far from the first point for a map of this voxel size",
                        "give a larger --voxel-m, or a shorter range of --scans"});
    }
    key = key << kBits | static_cast<std::uint64_t>(cell);
  }
  const auto [found, is_new] = index_.try_emplace(key, voxels_.size());
  if (is_new) voxels_.emplace_back();
  Voxel& voxel = voxels_[found->second];
  voxel.sum += from_origin;
  ++voxel.points;
}

Cloud VoxelMap::cloud() const {
  Cloud out;
  out.columns.push_back({"points", {}});
  for (const Voxel& voxel : voxels_) {
    out.points.emplace_back(*origin_0_ + voxel.sum / voxel.points);
    out.columns.front().values.push_back(voxel.points);
  }
  return out;
}

}  // namespace mapless::app
