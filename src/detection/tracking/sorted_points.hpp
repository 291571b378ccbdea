#pragma once

#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include <Eigen/Core>

namespace mapless::inline v1 {

/// Nearest-neighbour search among a few hundred points, sorted along the axis in which they are spread most.
/// For so few it is faster to build and to query than a k-d tree.
class SortedPoints {
 public:
  /// Replaces the points; the memory is kept.
  void assign(std::span<const Eigen::Vector3d> points);

  struct Nearest {
    std::size_t index = 0;  ///< in the order given; the lowest of equally near points
    double square = std::numeric_limits<double>::infinity();  ///< of its distance; infinite without points
    double second_square = std::numeric_limits<double>::infinity();  ///< of that of the second nearest
  };
  [[nodiscard]] Nearest nearest(const Eigen::Vector3d& p) const;

 private:
  struct Entry {
    Eigen::Vector3d point;
    std::size_t index;
  };
  Eigen::Index axis_ = 0;
  std::vector<Entry> entries_;
};

}  // namespace mapless
