#include "odometry/keypoints/edges.hpp"

#include <algorithm>
#include <tuple>

namespace mapless::inline v1 {
namespace {

// A return is an edge if the ray beside it goes on at least this far beyond the plane through the return.
// Chosen: curved surfaces change by less from one column to the next.
constexpr float kMinStep_m = 0.5F;
constexpr float kMinStepRatio = 0.05F;

// 1 / range [1/m] of what the ray of a cell met, 0 where it met nothing within range; where it is not known,
// `range_m` of the return beside it stands for it.
float inverse_range(const LidarScan& scan, int row, int column, float range_m) {
  if (column < 0 || column >= scan.columns) return 1 / range_m;
  const std::int32_t cell = scan.cell(row, column);
  if (cell >= 0) return 1 / scan.returns[static_cast<std::size_t>(cell)].range_m;
  return code_of_cell(cell) == ReturnCode::nothing ? 0 : 1 / range_m;
}

// Whether the ray on the side `step` of a return passed on. On a plane 1 / range is linear in the column, to
// the square of the angle between two columns: the ray on the other side tells where the surface of the
// return would go on. A wall seen aslant, or the ground that leaves the range, has no edge there: it would
// move with the sensor.
bool passes_on(const LidarScan& scan, const LidarReturn& r, int step) {
  const float inverse_m = inverse_range(scan, r.laser, r.column + step, r.range_m);
  const float other_inverse_m = inverse_range(scan, r.laser, r.column - step, r.range_m);
  const float expected_inverse_m = std::min(2 / r.range_m - other_inverse_m, 1 / r.range_m);
  const auto farthest_m = static_cast<float>(scan.model->max_range_m);
  if (expected_inverse_m * farthest_m <= 1) return false;
  const float expected_m = 1 / expected_inverse_m;
  const float range_m = inverse_m > 0 ? 1 / inverse_m : farthest_m;
  return range_m - expected_m > std::max(kMinStep_m, kMinStepRatio * expected_m);
}

bool is_edge(const LidarScan& scan, const LidarReturn& r, const OdometryParameters& parameters) {
  if (!(r.range_m >= parameters.min_range_m && r.range_m <= parameters.map_radius_m)) return false;
  return passes_on(scan, r, -1) || passes_on(scan, r, 1);
}

}  // namespace

std::vector<ScanPoint> select_edges(const LidarScan& scan, const OdometryParameters& parameters) {
  std::vector<ScanPoint> out;
  for (std::size_t i = 0; i < scan.returns.size(); ++i) {
    const LidarReturn& r = scan.returns[i];
    if (is_edge(scan, r, parameters))
      out.push_back({r.position_v, r.range_m, r.time_ns, r.laser, static_cast<std::uint32_t>(i)});
  }
  std::sort(out.begin(), out.end(), [](const ScanPoint& a, const ScanPoint& b) {
    return std::tuple(a.time_ns, a.return_index) < std::tuple(b.time_ns, b.return_index);
  });
  return out;
}

}  // namespace mapless
