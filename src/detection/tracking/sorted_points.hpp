#pragma once

#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include <Eigen/Core>

namespace mapless::inline v1 {

/// A few hundred points, sorted along the axis of the world they are spread over most: for so few, faster to
/// make and to ask than a tree.
class SortedPoints {
 public:
  /// In place of those before, whose memory is used again.
  void assign(std::span<const Eigen::Vector3d> points);

  struct Nearest {
    std::size_t index = 0;  ///< in the order given
    double square = std::numeric_limits<double>::infinity();
    double others_square = std::numeric_limits<double>::infinity();  ///< of the nearest of the others
  };
  /// Of those nearest to `p`, the lowest index; infinitely far without points.
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
