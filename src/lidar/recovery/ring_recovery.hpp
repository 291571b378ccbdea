#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

#include <mapless/core/time.hpp>
#include <mapless/lidar/lidar_model.hpp>
#include <mapless/lidar/lidar_scan.hpp>

namespace mapless::inline v1 {

/// Storage order of a bare cloud (points without ring and time), as in KITTI (HDL-64E, method.md section 4):
/// ring after ring; atan2(y, x) mod 2 pi increases inside a ring and drops between rings.
struct BareCloudLayout {
  /// Row (by increasing elevation) of the n-th stored ring. KITTI: top laser first.
  std::vector<int> row_of_ring;
  /// Positions of the hub's angle encoder in one turn if the azimuths show it (KITTI: 4000, 0.09 degrees);
  /// else 0.
  int encoder_steps = 0;
};

/// The layout for a sensor of which only the lasers are known: top laser first.
[[nodiscard]] BareCloudLayout top_first_layout(const LidarModel& model);

/// True for a possible measurement: finite, and at least 0.01 m from the spin axis (some writers store 0 0
/// 0).
[[nodiscard]] inline bool is_usable(const Eigen::Vector3f& point) {
  constexpr float kNearestToAxisSquared_m2 = 1e-4F;
  return point.allFinite() && point.head<2>().squaredNorm() >= kNearestToAxisSquared_m2;
}

/// Index of the first point of every stored ring, where the azimuth drops by more than half a radian. An
/// unusable point belongs to the ring of the point before it.
[[nodiscard]] std::vector<std::size_t> ring_starts(const std::vector<Eigen::Vector3f>& points);

/// Row of every point: from the order alone if the number of rings found is that of the lasers. Otherwise (a
/// ring is missing, split, or merged with the next) the assignment in stored order with the least distance of
/// the points from the beams of the model. Throws InputError naming `source` if the points do not lie on the
/// beams in that order.
[[nodiscard]] std::vector<std::int32_t> recover_lasers(const std::vector<Eigen::Vector3f>& points,
                                                       const LidarModel& model, const BareCloudLayout& layout,
                                                       const std::string& source);

/// Column and instant within the turn of every point.
struct RecoveredFirings {
  std::vector<std::int32_t> columns;
  std::vector<double> turn;         ///< fraction of the turn since its start, [0, 1)
  double residual_columns_rms = 0;  ///< of the columns from turn x model.columns
};

/// The hub angle of a point is its azimuth minus the azimuth offset of its laser and the angle its horizontal
/// origin subtends. With both unknown this is t = start + (end - start) (1 - atan2(y, x) / pi) / 2 for KITTI
/// (clockwise, seam at the rear). The column is the nearest one. A point less than half a column before the
/// end of the turn is nearest to column 0 and gets its time, so that column and time never differ by more
/// than a column. With a known encoder, every firing position gets its own column, the nearest free one, and
/// its time; otherwise two points may share a cell.
[[nodiscard]] RecoveredFirings recover_firings(const std::vector<Eigen::Vector3f>& points,
                                               const std::vector<std::int32_t>& lasers,
                                               const LidarModel& model, int encoder_steps);

/// RecoveredFirings::columns alone.
[[nodiscard]] std::vector<std::int32_t> recover_columns(const std::vector<Eigen::Vector3f>& points,
                                                        const std::vector<std::int32_t>& lasers,
                                                        const LidarModel& model, int encoder_steps);

/// Records of a bare cloud for organise(), with lasers, columns and times as above. Unusable points are
/// faulty returns.
[[nodiscard]] std::vector<LidarRecord> recover_records(const std::vector<Eigen::Vector3f>& points,
                                                       const LidarModel& model, const BareCloudLayout& layout,
                                                       Duration turn_duration, const std::string& source);

}  // namespace mapless
