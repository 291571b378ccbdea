#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <mapless/detection/freespace_votes.hpp>
#include <mapless/lidar/aligned_image.hpp>

namespace mapless {

/// The neighbours of a point in the scan image that belong to it in space. Each of two points must reach the
/// other, so that what is linked does not depend on which is asked.
class LinkedNeighbours {
 public:
  LinkedNeighbours(const LidarScan& scan, const LocalPoints& points, const VotingParameters& parameters)
      : scan_(scan), points_(points.points), link_m_(static_cast<float>(parameters.link_m)), image_(scan) {
    const double column_rad = 2 * std::numbers::pi / scan.model->columns;
    for (int l = 0; l < scan.rows(); ++l) {
      const double spacing = std::max(column_rad, scan.model->elevation_step(l));
      link_per_m_.push_back(
          static_cast<float>(std::max(parameters.link_per_m, parameters.link_spacings * spacing)));
    }
  }

  /// Calls `visit(j)` for every return j of the window of 2 half_rows + 1 lasers and 2 half_columns + 1
  /// columns around return i that is `wanted(j)` and linked to it, row by row; not for i.
  template <class Wanted, class Visit>
  void for_each(std::int32_t i, int half_rows, int half_columns, Wanted&& wanted, Visit&& visit) const {
    const LidarReturn& r = scan_.returns[static_cast<std::size_t>(i)];
    const Eigen::Vector3f& p = points_[static_cast<std::size_t>(i)];
    const float link = reach_m(r);
    const int left = image_.aligned_column(r.laser, r.column) - half_columns;
    const int last_row = std::min(r.laser + half_rows, scan_.rows() - 1);
    for (int row = std::max(r.laser - half_rows, 0); row <= last_row; ++row) {
      int column = image_.scan_column(row, left);
      for (int k = 0; k <= 2 * half_columns; ++k, column = column + 1 < scan_.columns ? column + 1 : 0) {
        const std::int32_t j = scan_.cell(row, column);
        if (j < 0 || j == i || !wanted(j)) continue;
        const float distance2 = (points_[static_cast<std::size_t>(j)] - p).squaredNorm();
        if (distance2 > link * link) continue;
        const float other = reach_m(scan_.returns[static_cast<std::size_t>(j)]);
        if (distance2 <= other * other) visit(j);
      }
    }
  }

 private:
  [[nodiscard]] float reach_m(const LidarReturn& r) const {
    return link_m_ + link_per_m_[static_cast<std::size_t>(r.laser)] * r.range_m;
  }

  const LidarScan& scan_;
  const std::vector<Eigen::Vector3f>& points_;
  float link_m_;
  AlignedImage image_;
  std::vector<float> link_per_m_;  // of each laser
};

}  // namespace mapless
