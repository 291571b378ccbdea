#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

namespace mapless::inline v1 {

/// The edges of the scans so far (select_edges), in a hash table of cubes. In: points; out: how well the
/// edges of another scan agree with them.
class EdgeGrid {
 public:
  /// An edge of the same object is at most this far [m]. Chosen: half the distance of the lines that two
  /// neighbouring lasers, 2 degrees apart, draw on a pole at 20 m.
  static constexpr double kReach_m = 0.4;

  void insert(const std::vector<Eigen::Vector3d>& points_0);
  /// The sum over `points_0` of the weight of the nearest edge, 0 where there is none.
  [[nodiscard]] double agreement(const std::vector<Eigen::Vector3d>& points_0) const;
  /// The edge nearest to a point; null if all are farther than kReach_m. Valid until the next insertion.
  [[nodiscard]] const Eigen::Vector3d* nearest(const Eigen::Vector3d& p_0) const;
  /// 1 - (d / kReach_m)^2 for the distance d between two points, 0 beyond kReach_m.
  [[nodiscard]] static double weight(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    return std::max(0.0, 1 - (a - b).squaredNorm() / (kReach_m * kReach_m));
  }

 private:
  std::vector<Eigen::Vector3d> points_0_;
  std::vector<std::int32_t> next_;   // of a point: the next one of its slot, -1 for none
  std::vector<std::int32_t> first_;  // of a slot; size a power of two
  int shift_ = 0;                    // leaves the high bits of the hash
};

/// With fewer edges in a scan chance decides. Chosen.
inline constexpr std::size_t kMinEdges = 50;

/// The mean weight (EdgeGrid::weight) of the edges of a scan, each with the nearest edge of the scan before:
/// 0 to 1. None if either scan has fewer than kMinEdges.
[[nodiscard]] std::optional<double> edge_agreement(const std::vector<Eigen::Vector3d>& earlier_0,
                                                   const std::vector<Eigen::Vector3d>& later_0);

}  // namespace mapless
