#include "detection/published/point_pool.hpp"

namespace mapless::inline v1 {
namespace {

double squared_distance_of_farthest_corner(const Eigen::AlignedBox3d& box, const Eigen::Vector3d& q) {
  return (q - box.min()).cwiseAbs().cwiseMax((q - box.max()).cwiseAbs()).squaredNorm();
}

}  // namespace

PointPool::PointPool(const std::vector<Eigen::Vector3d>& points, const std::vector<std::int32_t>& members) {
  entries_.reserve(members.size());
  for (const std::int32_t i : members) entries_.push_back({points[static_cast<std::size_t>(i)], i});
  nodes_.reserve(4 * entries_.size() / kLeafSize + 1);
  if (!entries_.empty()) build(0, static_cast<std::int32_t>(entries_.size()));
}

void PointPool::build(std::int32_t first, std::int32_t last) {
  Node node{{}, first, last - first, 0};
  for (std::int32_t k = first; k < last; ++k) node.box.extend(entries_[static_cast<std::size_t>(k)].p);
  const std::size_t n = nodes_.size();
  nodes_.push_back(node);
  if (last - first <= kLeafSize) return;
  Eigen::Index axis = 0;
  node.box.sizes().maxCoeff(&axis);
  const std::int32_t middle = first + (last - first) / 2;
  const auto begin = entries_.begin();
  std::nth_element(begin + first, begin + middle, begin + last,
                   [axis](const Entry& a, const Entry& b) { return a.p[axis] < b.p[axis]; });
  build(first, middle);
  nodes_[n].right_child = static_cast<std::int32_t>(nodes_.size());
  build(middle, last);
}

bool PointPool::any_in(std::size_t n, const Eigen::Vector3d& q, double squared_radius) const {
  const Node& node = nodes_[n];
  if (node.left == 0 || node.box.squaredExteriorDistance(q) > squared_radius * kPruningSlack) return false;
  if (squared_distance_of_farthest_corner(node.box, q) <= squared_radius) return true;
  if (node.right_child != 0) {
    return any_in(n + 1, q, squared_radius) ||
           any_in(static_cast<std::size_t>(node.right_child), q, squared_radius);
  }
  const auto first = entries_.begin() + node.first;
  return std::any_of(first, first + node.left,
                     [&](const Entry& entry) { return (entry.p - q).squaredNorm() <= squared_radius; });
}

}  // namespace mapless
