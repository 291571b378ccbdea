#pragma once

#include <cstddef>
#include <vector>

#include "detection/evidence/row_line.hpp"
#include <mapless/detection/parameters.hpp>
#include <mapless/geometry/compensated_scan.hpp>

namespace mapless::inline v1 {

/// Joins the straight spans a row is cut into to the lines that make faces of things: spans that follow one
/// another in nearly the same direction, over no gap.
class RowLines {
 public:
  /// Keeps references.
  RowLines(const LidarScan& scan, const LocalPoints& points, const VotingParameters& parameters)
      : scan_(scan),
        points_(points.points),
        link_m_(static_cast<float>(parameters.link_m)),
        link_per_m_(static_cast<float>(parameters.link_per_m)) {}

  /// The next span of a row, or the first of another.
  void add(std::size_t left, std::size_t right);
  /// After the last span.
  void end() { keep(); }
  [[nodiscard]] const std::vector<RowLine>& lines() const { return lines_; }

 private:
  void keep();

  const LidarScan& scan_;
  const std::vector<Eigen::Vector3f>& points_;
  float link_m_, link_per_m_;
  std::size_t first_ = 0, last_ = 0;  // of the line at hand; none where they are the same
  std::vector<RowLine> lines_;
};

}  // namespace mapless
