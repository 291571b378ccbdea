#include "odometry/keypoints/edges.hpp"

#include <algorithm>
#include <tuple>

namespace mapless::inline v1 {
namespace {

// A return is an edge if the ray beside it goes on at least this far. Chosen: surfaces seen aslant change by
// less from one column to the next (0.2 deg: 5 % is an angle of 4 deg between ray and surface).
constexpr float kMinStep_m = 0.5F;
constexpr float kMinStepRatio = 0.05F;

// Whether the ray of the cell beside a return of range `range_m` passed on.
bool passes_on(const LidarScan& scan, int row, int column, float range_m) {
  if (column < 0 || column >= scan.columns) return false;
  const std::int32_t cell = scan.cell(row, column);
  if (cell < 0) return code_of_cell(cell) == ReturnCode::nothing;
  return scan.returns[static_cast<std::size_t>(cell)].range_m - range_m >
         std::max(kMinStep_m, kMinStepRatio * range_m);
}

}  // namespace

std::vector<ScanPoint> select_edges(const LidarScan& scan, const OdometryParameters& parameters) {
  std::vector<ScanPoint> out;
  for (std::size_t i = 0; i < scan.returns.size(); ++i) {
    const LidarReturn& r = scan.returns[i];
    if (!(r.range_m >= parameters.min_range_m && r.range_m <= parameters.map_radius_m)) continue;
    if (passes_on(scan, r.laser, r.column - 1, r.range_m) ||
        passes_on(scan, r.laser, r.column + 1, r.range_m))
      out.push_back({r.position_v, r.range_m, r.time_ns, r.laser, static_cast<std::uint32_t>(i)});
  }
  std::sort(out.begin(), out.end(), [](const ScanPoint& a, const ScanPoint& b) {
    return std::tuple(a.time_ns, a.return_index) < std::tuple(b.time_ns, b.return_index);
  });
  return out;
}

}  // namespace mapless
