#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <unordered_map>
#include <vector>

#include <Eigen/Core>

#include "export/cloud.hpp"

namespace mapless::app {

/// A cloud of one point per voxel: the mean of the points in it.
class VoxelMap {
 public:
  /// `edge_m`: of a voxel [m], above 0.
  explicit VoxelMap(double edge_m) : edge_m_(edge_m) {}

  /// Throws InputError for a point more than a million voxels from the first one along an axis.
  void add(const Eigen::Vector3d& point_0);

  [[nodiscard]] std::size_t size() const { return voxels_.size(); }
  /// In the order in which the voxels were first met, with the column `points`: how many each has.
  [[nodiscard]] Cloud cloud() const;

 private:
  struct Voxel {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();  ///< of the points, relative to origin_0_
    std::uint32_t points = 0;
  };

  double edge_m_;
  std::optional<Eigen::Vector3d> origin_0_;  ///< the first point
  std::unordered_map<std::uint64_t, std::size_t> index_;
  std::vector<Voxel> voxels_;
};

}  // namespace mapless::app
