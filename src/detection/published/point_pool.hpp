#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace mapless::inline v1 {

/// Points that leave once they are taken: a k-d tree whose empty branches are skipped. A search that takes
/// what it finds looks at each point once, however densely the points lie, so that flooding n of them takes
/// O(n log n) steps; neighbours that are searched anew for each point take n times their number.
class PointPool {
 public:
  /// Of the finite `points` [m], those with the indices `members`.
  PointPool(const std::vector<Eigen::Vector3d>& points, const std::vector<std::int32_t>& members);

  /// Calls take(i) for every point i left within `radius_m` (inclusive) of q, in no particular order. Those
  /// for which it returns true leave the pool.
  template <class Take>
  void take_within(const Eigen::Vector3d& q, double radius_m, Take&& take) {
    if (!nodes_.empty()) take_from(0, q, radius_m * radius_m, take);
  }

  /// Whether any point left lies within `radius_m` (inclusive) of q.
  [[nodiscard]] bool any_within(const Eigen::Vector3d& q, double radius_m) const {
    return !nodes_.empty() && any_in(0, q, radius_m * radius_m);
  }

 private:
  // Points of a leaf. Chosen as for nanoflann, whose documentation recommends 10 to 50.
  static constexpr std::int32_t kLeafSize = 12;
  // Bounds of boxes carry rounding errors (1e-16 per operation): a bound wider by this factor loses no point.
  static constexpr double kPruningSlack = 1 + 1e-9;

  struct Entry {
    Eigen::Vector3d p;
    std::int32_t index;
  };
  struct Node {
    Eigen::AlignedBox3d box;
    std::int32_t first, left;  // entries, those of a leaf that are left in front
    std::int32_t right_child;  // 0: a leaf; the left child is the next node
  };

  void build(std::int32_t first, std::int32_t last);

  // The number of points taken.
  template <class Take>
  std::int32_t take_from(std::size_t n, const Eigen::Vector3d& q, double squared_radius, Take& take) {
    Node& node = nodes_[n];
    if (node.left == 0 || node.box.squaredExteriorDistance(q) > squared_radius * kPruningSlack) return 0;
    std::int32_t taken = 0;
    if (node.right_child != 0) {
      taken = take_from(n + 1, q, squared_radius, take);
      taken += take_from(static_cast<std::size_t>(node.right_child), q, squared_radius, take);
    } else {
      for (std::int32_t left = node.left, k = 0; k < left;) {
        Entry& entry = entries_[static_cast<std::size_t>(node.first + k)];
        if ((entry.p - q).squaredNorm() <= squared_radius && take(entry.index)) {
          std::swap(entry, entries_[static_cast<std::size_t>(node.first + --left)]);
          ++taken;
        } else {
          ++k;
        }
      }
    }
    node.left -= taken;
    return taken;
  }

  [[nodiscard]] bool any_in(std::size_t n, const Eigen::Vector3d& q, double squared_radius) const;

  std::vector<Entry> entries_;
  std::vector<Node> nodes_;
};

}  // namespace mapless
