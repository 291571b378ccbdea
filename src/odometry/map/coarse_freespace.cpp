#include "odometry/map/coarse_freespace.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace mapless::inline v1 {
namespace {

// Cells of 2 degrees of elevation, no narrower than the gaps between the lasers of a VLP-16, by 1 of azimuth.
constexpr int kRows = 90;
constexpr int kColumns = 360;
constexpr std::size_t kMaxReturns = 30000;  // chosen: about one a cell, kRows x kColumns
// Tolerance: surfaces seen aslant change by less from one cell to the next. Chosen.
constexpr double kTolerance_m = 0.5;
constexpr double kTolerancePerMetre = 0.05;
constexpr double kMinRange_m = 1;  // returns nearer than this are of the vehicle itself; chosen

std::size_t cell_of(int row, int column) {
  return static_cast<std::size_t>(row * kColumns + (column + kColumns) % kColumns);
}

}  // namespace

CoarseFreespace::Direction CoarseFreespace::direction_of(const Eigen::Vector3d& p_v, double range_m) {
  const double elevation = std::asin(std::clamp(p_v.z() / range_m, -1.0, 1.0));
  const double azimuth = std::atan2(p_v.y(), p_v.x());
  const int row = static_cast<int>((elevation / std::numbers::pi + 0.5) * kRows);
  const int column = static_cast<int>((azimuth / std::numbers::pi + 1) * 0.5 * kColumns);
  return {std::clamp(row, 0, kRows - 1), std::clamp(column, 0, kColumns - 1)};
}

CoarseFreespace::CoarseFreespace(const LidarScan& scan)
    : shortest_m_(kRows * kColumns, 0.F),
      column_times_(kColumns,
                    scan.start + Duration::from_nanoseconds((scan.end() - scan.start).nanoseconds() / 2)) {
  const std::size_t stride = scan.returns.size() / kMaxReturns + 1;
  for (std::size_t i = 0; i < scan.returns.size(); i += stride) {
    const LidarReturn& r = scan.returns[i];
    const Eigen::Vector3d p_v = r.position_v.cast<double>();
    const double range = p_v.norm();
    if (!(range >= kMinRange_m)) continue;
    const Direction at = direction_of(p_v, range);
    float& nearest = shortest_m_[cell_of(at.row, at.column)];
    if (nearest == 0 || range < nearest) nearest = static_cast<float>(range);
    column_times_[static_cast<std::size_t>(at.column)] = scan.time_of(r);
  }
}

double CoarseFreespace::shortest_about(const Direction& at) const {
  if (shortest_m_[cell_of(at.row, at.column)] == 0) return 0;
  float nearest = shortest_m_[cell_of(at.row, at.column)];
  for (int row = std::max(0, at.row - 1); row <= std::min(kRows - 1, at.row + 1); ++row) {
    for (int column = at.column - 1; column <= at.column + 1; ++column) {
      const float m = shortest_m_[cell_of(row, column)];
      if (m > 0) nearest = std::min(nearest, m);
    }
  }
  return nearest;
}

FreespaceVerdict CoarseFreespace::verdict(const Eigen::Vector3d& p_v) const {
  const double range = p_v.norm();
  const double shortest = shortest_about(direction_of(p_v, range));
  if (shortest == 0 || range < kMinRange_m) return FreespaceVerdict::unobserved;
  return compare_ranges(shortest, range, kTolerance_m + kTolerancePerMetre * range);
}

int CoarseFreespace::count_inside(const KnotInterval& own, const TimeBins& bins,
                                  const KnotInterval& interval) const {
  std::vector<SE3> T_v0;  // of every column
  for (const Time& time : column_times_) T_v0.push_back(own.at(time).state.T_v0);
  const SE3 T_middle = T_v0[kColumns / 2];
  int inside = 0;
  for (const TimeBins::Bin& bin : bins.bins()) {
    const SE3 T_0v = interval.at(bin.time).state.T_v0.inverse();
    for (std::size_t i = bin.begin; i < bin.end; ++i) {
      const Eigen::Vector3d p_0 = T_0v * bins.points()[i].position_v;
      const Eigen::Vector3d about = T_middle * p_0;
      const auto column = static_cast<std::size_t>(direction_of(about, about.norm()).column);
      const Eigen::Vector3d p_v = T_v0[column] * p_0;
      inside += verdict(p_v) == FreespaceVerdict::inside ? 1 : 0;
    }
  }
  return inside;
}

}  // namespace mapless
