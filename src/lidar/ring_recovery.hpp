#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

#include <mapless/core/time.hpp>
#include <mapless/lidar/lidar_model.hpp>
#include <mapless/lidar/lidar_scan.hpp>

namespace mapless::inline v1 {

/// How a bare cloud (points only: no ring, no time) is stored, as KITTI stores its HDL-64E (method.md section
/// 4): ring after ring, atan2(y, x) mod 2 pi rising inside a ring and dropping between rings.
struct BareCloudLayout {
  /// Row (by increasing elevation) of the n-th stored ring. KITTI: top laser first.
  std::vector<int> row_of_ring;
  /// Positions of the hub's angle encoder in one turn, where the azimuths show it (KITTI: 4000, 0.09
  /// degrees); else 0.
  int encoder_steps = 0;
};

/// The layout of a sensor of which nothing but its lasers is known: top laser first.
[[nodiscard]] BareCloudLayout top_first_layout(const LidarModel& model);

/// True for points a laser can have measured: finite, and not on the spin axis (some writers store 0 0 0).
[[nodiscard]] bool is_usable(const Eigen::Vector3f& point);

/// Index of the first point of every stored ring: where the azimuth drops by more than half a radian.
/// Unusable points belong to the ring they stand in.
[[nodiscard]] std::vector<std::size_t> ring_starts(const std::vector<Eigen::Vector3f>& points);

/// Row of every point. From the order alone where as many rings are found as the model has lasers. Where a
/// ring is missing, split, or runs into the next: the assignment in stored order that brings the points
/// nearest to the model's beams. Throws InputError naming `source` where the points do not lie on the model's
/// beams in that order.
[[nodiscard]] std::vector<std::int32_t> recover_lasers(const std::vector<Eigen::Vector3f>& points,
                                                       const LidarModel& model, const BareCloudLayout& layout,
                                                       const std::string& source);

/// Where in the turn every point was measured.
struct RecoveredFirings {
  std::vector<std::int32_t> columns;
  std::vector<double> turn;         ///< fraction of the turn since its start, [0, 1)
  double residual_columns_rms = 0;  ///< of the columns from turn x model.columns
};

/// The hub's angle at every point is its azimuth less its laser's own part (azimuth offset, horizontal
/// origin); with none of these known, t = start + (end - start) (1 - atan2(y, x) / pi) / 2 for KITTI
/// (clockwise, seam at the rear). The column is the nearest one; points less than half a column before the
/// end of the turn are nearest to column 0, and have its time: column and turn are never more than a column
/// apart. Where the encoder is known, the positions at which the sensor fired are found, and every firing has
/// a column of its own (the nearest free one), and its time; otherwise two points may share a cell.
[[nodiscard]] RecoveredFirings recover_firings(const std::vector<Eigen::Vector3f>& points,
                                               const std::vector<std::int32_t>& lasers,
                                               const LidarModel& model, int encoder_steps);

/// Records of a bare cloud, for organise(): lasers, columns and times as above. Unusable points are faulty
/// returns.
[[nodiscard]] std::vector<LidarRecord> recover_records(const std::vector<Eigen::Vector3f>& points,
                                                       const LidarModel& model, const BareCloudLayout& layout,
                                                       Duration turn_duration, const std::string& source);

}  // namespace mapless
