#include "detection/sorted_points.hpp"

#include <algorithm>
#include <utility>

#include <Eigen/Geometry>

namespace mapless {

SortedPoints::SortedPoints(std::vector<Eigen::Vector3d> points) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& p : points) box.extend(p);
  if (!box.isEmpty()) box.sizes().maxCoeff(&axis_);
  std::vector<std::pair<double, std::size_t>> order;
  order.reserve(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) order.emplace_back(points[i][axis_], i);
  std::sort(order.begin(), order.end());
  entries_.reserve(points.size());
  for (const auto& [along, index] : order) entries_.push_back({points[index], index});
}

SortedPoints::Nearest SortedPoints::nearest(const Eigen::Vector3d& p) const {
  Nearest out;
  // False where this one, and all beyond it, are farther than the nearest so far.
  const auto look = [&](const Entry& entry) {
    const double along = entry.point[axis_] - p[axis_];
    if (along * along > out.square) return false;
    const double square = (entry.point - p).squaredNorm();
    if (square < out.square || (square == out.square && entry.index < out.index)) out = {entry.index, square};
    return true;
  };
  const auto middle = std::partition_point(entries_.begin(), entries_.end(),
                                           [&](const Entry& entry) { return entry.point[axis_] < p[axis_]; });
  auto up = middle, down = middle;
  bool go_up = true, go_down = true;
  while (go_up || go_down) {
    go_up = go_up && up != entries_.end() && look(*up++);
    go_down = go_down && down != entries_.begin() && look(*--down);
  }
  return out;
}

}  // namespace mapless
