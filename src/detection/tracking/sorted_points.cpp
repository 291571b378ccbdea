#include "detection/tracking/sorted_points.hpp"

#include <algorithm>

#include <Eigen/Geometry>

namespace mapless::inline v1 {

void SortedPoints::assign(std::span<const Eigen::Vector3d> points) {
  entries_.clear();
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& p : points) {
    box.extend(p);
    entries_.push_back({p, entries_.size()});
  }
  if (!box.isEmpty()) box.sizes().maxCoeff(&axis_);
  std::sort(entries_.begin(), entries_.end(),
            [this](const Entry& a, const Entry& b) { return a.point[axis_] < b.point[axis_]; });
}

SortedPoints::Nearest SortedPoints::nearest(const Eigen::Vector3d& p) const {
  Nearest out;
  // Returns false if this entry, and hence all beyond it, are farther than the nearest two so far.
  const auto visit = [&](const Entry& entry) {
    const double along = entry.point[axis_] - p[axis_];
    if (along * along > out.second_square) return false;
    const double square = (entry.point - p).squaredNorm();
    if (square < out.square || (square == out.square && entry.index < out.index)) {
      out = {entry.index, square, out.square};
    } else {
      out.second_square = std::min(out.second_square, square);
    }
    return true;
  };
  const auto middle = std::partition_point(entries_.begin(), entries_.end(),
                                           [&](const Entry& entry) { return entry.point[axis_] < p[axis_]; });
  auto up = middle, down = middle;
  bool go_up = true, go_down = true;
  while (go_up || go_down) {
    go_up = go_up && up != entries_.end() && visit(*up++);
    go_down = go_down && down != entries_.begin() && visit(*--down);
  }
  return out;
}

}  // namespace mapless
