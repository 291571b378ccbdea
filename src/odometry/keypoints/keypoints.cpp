#include "odometry/keypoints/keypoints.hpp"

#include <algorithm>
#include <bit>
#include <utility>

#include "odometry/map/cube_hash.hpp"

namespace mapless::inline v1 {
namespace {

/// A set of cubes, in an open-addressing table of fixed size that is at most half full.
class CubeSet {
 public:
  explicit CubeSet(std::size_t max_cubes)
      : table_(std::bit_ceil(2 * max_cubes + 2), kNoCube), shift_(64 - std::countr_zero(table_.size())) {}

  /// False if the cube was in the set already.
  bool insert(std::uint64_t key) {
    const std::size_t mask = table_.size() - 1;
    std::size_t slot = cube_slot(key, shift_);
    for (; table_[slot] != kNoCube; slot = (slot + 1) & mask) {
      if (table_[slot] == key) return false;
    }
    table_[slot] = key;
    return true;
  }

 private:
  std::vector<std::uint64_t> table_;
  int shift_;
};

std::vector<std::uint32_t> one_per_cube(const std::vector<ScanPoint>& points, double cube_m) {
  const double cubes_per_m = 1 / cube_m;
  const Eigen::Vector3d half = Eigen::Vector3d::Constant(0.5);
  CubeSet seen(points.size());
  std::vector<std::uint32_t> out;
  const std::vector<std::uint32_t> by_pass = pass_order(points.size());
  for (const std::uint32_t k : golden_order(points.size())) {
    const std::uint32_t i = by_pass[k];
    const Eigen::Vector3d p = points[i].position_v.cast<double>() * cubes_per_m - half;
    if (seen.insert(cube_key(p.x(), p.y(), p.z()))) out.push_back(i);
  }
  return out;
}

}  // namespace

std::vector<ScanPoint> select_keypoints(const std::vector<ScanPoint>& points,
                                        const OdometryParameters& parameters, int max_halvings) {
  double cube_m = parameters.keypoint_voxel_m;
  std::vector<std::uint32_t> chosen = one_per_cube(points, cube_m);
  for (int i = 0; i < max_halvings && chosen.size() < static_cast<std::size_t>(parameters.min_keypoints);
       ++i) {
    cube_m /= 2;
    chosen = one_per_cube(points, cube_m);
  }
  // Points are in the order of the returns: equal times are ordered by the number of the return.
  std::vector<std::pair<std::int32_t, std::uint32_t>> by_time;
  by_time.reserve(chosen.size());
  for (const std::uint32_t i : chosen) by_time.emplace_back(points[i].time_ns, i);
  std::sort(by_time.begin(), by_time.end());
  std::vector<ScanPoint> out;
  out.reserve(chosen.size());
  for (const auto& [time_ns, i] : by_time) out.push_back(points[i]);
  return out;
}

}  // namespace mapless
