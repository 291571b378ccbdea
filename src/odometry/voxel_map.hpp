#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

namespace mapless {

/// A plane fitted to points of the map near some query point.
struct MapPlane {
  Eigen::Vector3d point_0;   ///< their mean
  Eigen::Vector3d normal_0;  ///< unit length
  double planarity;          ///< (middle - smallest) / largest standard deviation, 0 to 1
};

/// Points of the world in cubes of a hash table, at most 20 each and no two nearer than a spacing. Points of
/// a cube are kept as floats from its corner, so that precision does not fade far from the origin. What is in
/// it depends on the order of insertion alone.
class VoxelMap {
 public:
  static constexpr int kSlots = 20;

  static constexpr double kVoxel = 1.0;    ///< [m] (method.md section 6)
  static constexpr double kSpacing = 0.1;  ///< [m]

  explicit VoxelMap(double voxel_m = kVoxel, double spacing_m = kSpacing);

  /// Ignores points that are not finite or farther than 1e6 cubes from the origin.
  void insert(const Eigen::Vector3d& p_0);
  /// Forgets the cubes whose corner is farther from `centre_0`.
  void keep_within(const Eigen::Vector3d& centre_0, double radius_m);
  void clear();

  /// Plane of the (at most 20) nearest of the points in the eight cubes nearest to `q_0`; none with fewer
  /// than ten, or where they lie on one line.
  [[nodiscard]] std::optional<MapPlane> plane_near(const Eigen::Vector3d& q_0) const;

  [[nodiscard]] std::size_t voxels() const { return voxels_.size(); }
  [[nodiscard]] std::size_t points() const;

 private:
  struct Voxel {
    Eigen::Array3i corner;  // in cubes
    int count = 0;
    std::array<Eigen::Vector3f, kSlots> points;  // from the corner [m]
  };

  [[nodiscard]] const Voxel* find(const Eigen::Array3i& corner) const;
  [[nodiscard]] Voxel& find_or_add(const Eigen::Array3i& corner);
  [[nodiscard]] std::size_t slot_of(const Eigen::Array3i& corner) const;
  void rebuild_table(std::size_t capacity);

  double voxel_m_;
  float spacing_squared_;
  std::vector<Voxel> voxels_;        // in the order they came
  std::vector<std::int32_t> table_;  // indices into voxels_, -1 for empty; size a power of two
  int shift_ = 0;                    // leaves the high bits of the hash
};

}  // namespace mapless
