#include "odometry/map/edge_grid.hpp"

#include <algorithm>
#include <bit>

#include "odometry/map/cube_hash.hpp"

namespace mapless::inline v1 {
namespace {

// A ball of kReach_m lies within the eight cubes nearest to its centre.
constexpr double kCubesPerMetre = 1 / (2 * EdgeGrid::kReach_m);
// Half a side, a little less: at the very middle of a cube, half a side leads past it to both sides. The
// weight of an edge beyond is 0 to 1e-8.
constexpr double kHalfSide = 0.5 - 1e-9;
constexpr std::size_t kMinSlots = 1024;  // affects speed alone

}  // namespace

void EdgeGrid::insert(const std::vector<Eigen::Vector3d>& points_0) {
  points_0_.insert(points_0_.end(), points_0.begin(), points_0.end());
  first_.assign(std::bit_ceil(std::max(kMinSlots, 2 * points_0_.size())), -1);
  shift_ = 64 - std::countr_zero(first_.size());
  next_.assign(points_0_.size(), -1);
  for (std::size_t i = 0; i < points_0_.size(); ++i) {
    const Eigen::Vector3d at = kCubesPerMetre * points_0_[i];
    std::int32_t& first = first_[cube_slot(cube_key(at.x(), at.y(), at.z()), shift_)];
    next_[i] = first;
    first = static_cast<std::int32_t>(i);
  }
}

const Eigen::Vector3d* EdgeGrid::nearest(const Eigen::Vector3d& p_0) const {
  if (first_.empty()) return nullptr;
  const Eigen::Vector3d at = kCubesPerMetre * p_0;
  const Eigen::Vector3d* out = nullptr;
  double square = kReach_m * kReach_m;
  for (unsigned corner = 0; corner < 8; ++corner) {
    const auto side = [corner](unsigned axis) { return (corner >> axis & 1U) != 0 ? kHalfSide : -kHalfSide; };
    const std::uint64_t key = cube_key(at.x() + side(0), at.y() + side(1), at.z() + side(2));
    for (std::int32_t i = first_[cube_slot(key, shift_)]; i >= 0; i = next_[static_cast<std::size_t>(i)]) {
      const Eigen::Vector3d& edge = points_0_[static_cast<std::size_t>(i)];
      const double s = (edge - p_0).squaredNorm();
      if (s >= square) continue;
      square = s;
      out = &edge;
    }
  }
  return out;
}

double EdgeGrid::agreement(const std::vector<Eigen::Vector3d>& points_0) const {
  double out = 0;
  for (const Eigen::Vector3d& p_0 : points_0) {
    const Eigen::Vector3d* edge = nearest(p_0);
    if (edge != nullptr) out += weight(*edge, p_0);
  }
  return out;
}

std::optional<double> edge_agreement(const std::vector<Eigen::Vector3d>& earlier_0,
                                     const std::vector<Eigen::Vector3d>& later_0) {
  if (std::min(earlier_0.size(), later_0.size()) < kMinEdges) return std::nullopt;
  EdgeGrid earlier;
  earlier.insert(earlier_0);
  return earlier.agreement(later_0) / static_cast<double>(later_0.size());
}

}  // namespace mapless
