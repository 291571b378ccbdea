#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>
#include <vector>

#include "detection/segmentation/marked_returns.hpp"
#include "lidar/aligned_image.hpp"
#include <mapless/detection/parameters.hpp>
#include <mapless/geometry/compensated_scan.hpp>

namespace mapless::inline v1 {

/// Half sizes of windows of the scan image. Support of a point comes from its immediate neighbours, 3 x 5
/// cells, as in the box filter of paper step 4. Clusters and growth use 5 x 9 cells, to step over a laser or
/// a few columns occluded by something in front.
inline constexpr int kSupportRows = 1, kSupportColumns = 2;
inline constexpr int kLinkRows = 2, kLinkColumns = 4;

/// The neighbours of a return in the aligned scan image that are linked to it in space: each of the two is
/// within the link distance of the other, link_m + range x max(link_per_m, link_spacings x spacing of the
/// rays), so that linking is symmetric (paper step 5, radially bounded nearest neighbours).
class LinkedNeighbours {
 public:
  LinkedNeighbours(const LidarScan& scan, const LocalPoints& points, const VotingParameters& parameters)
      : scan_(scan), points_(points.points), link_m_(static_cast<float>(parameters.link_m)), image_(scan) {
    const double column_rad = 2 * std::numbers::pi / scan.model->columns;
    link_per_m_.reserve(scan.model->lasers.size());
    for (int l = 0; l < scan.rows(); ++l) {
      const double spacing = std::max(column_rad, scan.model->elevation_step(l));
      link_per_m_.push_back(
          static_cast<float>(std::max(parameters.link_per_m, parameters.link_spacings * spacing)));
    }
  }

  /// Calls `visit(j)` for every return j of the window of 2 half_rows + 1 lasers and 2 half_columns + 1
  /// columns around return i that is linked to it, row by row; not for i.
  template <class Visit>
  void for_each(std::int32_t i, int half_rows, int half_columns, Visit&& visit) const {
    const LidarReturn& r = scan_.returns[static_cast<std::size_t>(i)];
    const Eigen::Vector3f& p = points_[static_cast<std::size_t>(i)];
    const float link = link_distance_m(r);
    const int left = image_.aligned_column(r.laser, r.column) - half_columns;
    const int last_row = std::min(r.laser + half_rows, scan_.rows() - 1);
    for (int row = std::max(r.laser - half_rows, 0); row <= last_row; ++row) {
      int column = image_.scan_column(row, left);
      for (int k = 0; k <= 2 * half_columns; ++k, column = column + 1 < scan_.columns ? column + 1 : 0) {
        const std::int32_t j = scan_.cell(row, column);
        if (j >= 0 && j != i && linked(p, link, j)) visit(j);
      }
    }
  }

  enum class Of { marked, unmarked };
  /// The same for marked or unmarked returns only; `visit(j)` may change the mark of j.
  template <Of which, class Visit>
  void for_each(std::int32_t i, int half_rows, int half_columns, const MarkedReturns& marks,
                Visit&& visit) const {
    const LidarReturn& r = scan_.returns[static_cast<std::size_t>(i)];
    const Eigen::Vector3f& p = points_[static_cast<std::size_t>(i)];
    const float link = link_distance_m(r);
    const int left = image_.aligned_column(r.laser, r.column) - half_columns;
    const int last_row = std::min(r.laser + half_rows, scan_.rows() - 1);
    const int width = 2 * half_columns + 1;
    for (int row = std::max(r.laser - half_rows, 0); row <= last_row; ++row) {
      std::uint64_t cells = marks.window(row, left, width);
      if constexpr (which == Of::unmarked) cells ^= (std::uint64_t{1} << width) - 1;
      for (; cells != 0; cells &= cells - 1) {
        const std::int32_t j = scan_.cell(row, image_.scan_column(row, left + std::countr_zero(cells)));
        if (j >= 0 && j != i && linked(p, link, j)) visit(j);
      }
    }
  }

  enum class Axis { columns, rows };
  /// The return `steps` columns or rows from return i in the aligned image (left and down are negative).
  /// Below 0: none.
  [[nodiscard]] std::int32_t beside(std::int32_t i, Axis axis, int steps) const {
    const LidarReturn& r = scan_.returns[static_cast<std::size_t>(i)];
    const int row = r.laser + (axis == Axis::rows ? steps : 0);
    if (row < 0 || row >= scan_.rows()) return empty_cell(ReturnCode::absent);
    const int column = image_.aligned_column(r.laser, r.column) + (axis == Axis::columns ? steps : 0);
    return scan_.cell(row, image_.scan_column(row, column));
  }

  /// Whether returns i and j are linked in space, wherever they are in the scan image.
  [[nodiscard]] bool linked(std::int32_t i, std::int32_t j) const {
    return linked(points_[static_cast<std::size_t>(i)],
                  link_distance_m(scan_.returns[static_cast<std::size_t>(i)]), j);
  }

  [[nodiscard]] const AlignedImage& image() const { return image_; }

 private:
  [[nodiscard]] bool linked(const Eigen::Vector3f& p, float reach, std::int32_t j) const {
    const float distance2 = (points_[static_cast<std::size_t>(j)] - p).squaredNorm();
    if (distance2 > reach * reach) return false;
    const float other = link_distance_m(scan_.returns[static_cast<std::size_t>(j)]);
    return distance2 <= other * other;
  }
  [[nodiscard]] float link_distance_m(const LidarReturn& r) const {
    return link_m_ + link_per_m_[static_cast<std::size_t>(r.laser)] * r.range_m;
  }

  const LidarScan& scan_;
  const std::vector<Eigen::Vector3f>& points_;
  float link_m_;
  AlignedImage image_;
  std::vector<float> link_per_m_;  // by laser
};

}  // namespace mapless
