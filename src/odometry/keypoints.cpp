#include "odometry/keypoints.hpp"

#include <algorithm>
#include <bit>

#include "odometry/cube_hash.hpp"

namespace mapless {
namespace {

constexpr int kHalvings = 2;

/// Cubes seen so far, in an open-addressing table made large enough at once.
class CubeSet {
 public:
  explicit CubeSet(std::size_t most)
      : table_(std::bit_ceil(2 * most + 2), kEmpty), shift_(64 - std::countr_zero(table_.size())) {}

  /// False where it was there already.
  bool insert(std::uint64_t key) {
    const std::size_t mask = table_.size() - 1;
    std::size_t slot = cube_slot(key, shift_);
    for (; table_[slot] != kEmpty; slot = (slot + 1) & mask) {
      if (table_[slot] == key) return false;
    }
    table_[slot] = key;
    return true;
  }

 private:
  static constexpr std::uint64_t kEmpty = ~std::uint64_t{0};  // keys have 63 bits
  std::vector<std::uint64_t> table_;
  int shift_;
};

std::vector<Keypoint> one_per_cube(const std::vector<Keypoint>& points, double cube_m) {
  CubeSet seen(points.size());
  std::vector<Keypoint> out;
  for (const Keypoint& point : points) {
    if (seen.insert(cube_key(cube_of(point.position_v, cube_m)))) out.push_back(point);
  }
  return out;
}

}  // namespace

std::vector<Keypoint> select_keypoints(const LidarScan& scan, const OdometryParameters& parameters) {
  std::vector<Keypoint> usable;
  usable.reserve(scan.returns.size());
  for (const LidarReturn& r : scan.returns) {
    const Eigen::Vector3d p = r.position_v.cast<double>();
    const double range = p.norm();
    if (range >= parameters.min_range_m && range <= parameters.map_radius_m) usable.push_back({p, r.time_ns});
  }
  double cube_m = parameters.keypoint_voxel_m;
  std::vector<Keypoint> out = one_per_cube(usable, cube_m);
  for (int i = 0; i < kHalvings && out.size() < static_cast<std::size_t>(parameters.min_keypoints); ++i) {
    cube_m /= 2;
    out = one_per_cube(usable, cube_m);
  }
  std::stable_sort(out.begin(), out.end(),
                   [](const Keypoint& a, const Keypoint& b) { return a.time_ns < b.time_ns; });
  return out;
}

}  // namespace mapless
