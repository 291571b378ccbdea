#include "lidar/self_check/range_check.hpp"

#include <algorithm>
#include <array>
#include <vector>

#include <fmt/format.h>

namespace mapless::inline v1 {
namespace {

// Sensors see a little farther than their data sheet says, bright surfaces above all.
constexpr double kBeyond = 1.25;
// Shares of the points beyond that. Chosen: one surface in fifty may be a retroreflector; a fifth is none.
constexpr double kDoubtfulShare = 0.02, kWrongShare = 0.2;
// Nearly all points nearer than this are in kilometres, or of no spinning lidar.
constexpr double kAllNearer_m = 1;
// The far end of the points lies between these shares of the maximum range where their unit is right.
constexpr double kNearestEnd = 0.15, kFarthestEnd = 1.25;

struct UnitOfLength {
  const char* name;
  double metres;
};
constexpr std::array<UnitOfLength, 3> kUnitsOfLength = {
    {{"millimetres", 1e-3}, {"centimetres", 1e-2}, {"feet", 0.3048}}};

std::string likely_unit(double far_end_m, double max_range_m) {
  // The largest unit that explains the points: feet before centimetres.
  for (auto unit = kUnitsOfLength.rbegin(); unit != kUnitsOfLength.rend(); ++unit) {
    const double end = far_end_m * unit->metres;
    if (end > kNearestEnd * max_range_m && end < kFarthestEnd * max_range_m)
      return fmt::format("points look like {}, or max_range_m is too small", unit->name);
  }
  return "max_range_m is too small, or points are in another unit";
}

}  // namespace

ScanFinding check_ranges(const LidarScan& scan) {
  ScanFinding found;
  std::vector<float> ranges;
  for (const LidarReturn& r : scan.returns) ranges.push_back(r.range_m);
  if (ranges.size() < kFewestSamples) {
    found.measured = fmt::format("not checked: {} points", ranges.size());
    return found;
  }
  const double limit_m = kBeyond * scan.model->max_range_m;
  const auto beyond = std::count_if(ranges.begin(), ranges.end(), [&](float r) { return r > limit_m; });
  found.size = static_cast<double>(beyond) / static_cast<double>(ranges.size());
  const auto end = ranges.begin() + static_cast<std::ptrdiff_t>(0.99 * static_cast<double>(ranges.size()));
  std::nth_element(ranges.begin(), end, ranges.end());
  const double far_end_m = *end;
  found.measured = fmt::format("99 % of the points are nearer than {:.1f} m; the sensor sees up to {:g} m",
                               far_end_m, scan.model->max_range_m);
  found.trust = Trust::right;
  if (found.size > kDoubtfulShare) {
    found.trust = found.size > kWrongShare ? Trust::wrong : Trust::doubtful;
    found.problem = fmt::format("{:.0f} % of the points are farther than the {:g} m that {} sees: {}",
                                100 * found.size, scan.model->max_range_m, scan.model->name,
                                likely_unit(far_end_m, scan.model->max_range_m));
    found.remedy = "give points in metres, and the sensor's maximum range";
  } else if (far_end_m < kAllNearer_m) {
    found.trust = Trust::wrong;
    found.problem =
        fmt::format("99 % of the points are nearer than {:.3f} m: points look like kilometres", far_end_m);
    found.remedy = "give points in metres";
  }
  return found;
}

}  // namespace mapless
