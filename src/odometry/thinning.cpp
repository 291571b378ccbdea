#include "odometry/thinning.hpp"

#include <algorithm>
#include <numeric>

namespace mapless {
namespace {

constexpr std::size_t kSample = 1021;  // returns that tell how ranges are distributed

constexpr float kElevationSteps = 115;  // half a degree each

// A number in [0, 1) for a return, as good as random.
float unit_of(std::size_t i) {
  const auto bits = static_cast<std::uint32_t>(static_cast<std::uint64_t>(i) * 0x9E3779B97F4A7C15u >> 40);
  return static_cast<float>(bits) * 0x1p-24F;
}

// A step that visits every index once, neighbours far apart: near the golden section, and prime to the size.
std::size_t stride_through(std::size_t size) {
  auto stride = static_cast<std::size_t>(0.618 * static_cast<double>(size)) + 1;
  while (std::gcd(stride, size) != 1) ++stride;
  return stride;
}

// The squared range r^2 with sum of min(1, range^2 / r^2) equal to the points wanted.
float full_square_of(const std::vector<ScanPoint>& points, std::size_t wanted) {
  std::vector<float> squares;
  const std::size_t step = points.size() / kSample + 1;
  for (std::size_t i = 0; i < points.size(); i += step)
    squares.push_back(points[i].range_m * points[i].range_m);
  std::sort(squares.begin(), squares.end());
  const double share = static_cast<double>(wanted) / static_cast<double>(points.size());
  const double target = share * static_cast<double>(squares.size());
  // With the first k below r^2: their sum / r^2 + the rest = target.
  double sum = 0;
  for (std::size_t k = 0; k < squares.size(); ++k) {
    const double rest = static_cast<double>(squares.size() - k);
    if (rest <= target) break;
    sum += squares[k];
    const double r2 = sum / std::max(target - (rest - 1), 1e-9);
    if (target > rest - 1 && (k + 1 == squares.size() || r2 <= squares[k + 1])) return static_cast<float>(r2);
  }
  return static_cast<float>(sum / std::max(target, 1e-9));
}

// Where the recording does not tell the lasers apart, points of one elevation count as one laser's.
void tell_lasers_apart(std::vector<ScanPoint>& points) {
  const bool known = std::any_of(points.begin(), points.end(),
                                 [&](const ScanPoint& p) { return p.laser != points.front().laser; });
  if (known) return;
  for (ScanPoint& p : points)
    p.laser = static_cast<std::int32_t>((p.position_v.z() / p.range_m + 1) * kElevationSteps);
}

}  // namespace

std::vector<ScanPoint> thin(const LidarScan& scan, const OdometryParameters& parameters) {
  const auto nearest = static_cast<float>(parameters.min_range_m);
  const auto farthest = static_cast<float>(parameters.map_radius_m);
  std::vector<ScanPoint> usable;
  usable.reserve(scan.returns.size());
  for (std::size_t i = 0; i < scan.returns.size(); ++i) {
    const LidarReturn& r = scan.returns[i];
    const float range = r.position_v.norm();
    if (range >= nearest && range <= farthest)
      usable.push_back({r.position_v, range, r.time_ns, r.laser, static_cast<std::uint32_t>(i)});
  }
  tell_lasers_apart(usable);
  const auto wanted = static_cast<std::size_t>(parameters.max_scan_points);
  if (usable.size() > wanted) {
    const float full = full_square_of(usable, wanted);
    const auto out = std::remove_if(usable.begin(), usable.end(), [&](const ScanPoint& p) {
      return unit_of(p.return_index) * full >= p.range_m * p.range_m;
    });
    usable.erase(out, usable.end());
  }
  if (usable.empty()) return usable;
  std::vector<ScanPoint> mixed;
  mixed.reserve(usable.size());
  const std::size_t stride = stride_through(usable.size());
  for (std::size_t n = 0, i = 0; n < usable.size(); ++n, i = (i + stride) % usable.size())
    mixed.push_back(usable[i]);
  return mixed;
}

}  // namespace mapless
