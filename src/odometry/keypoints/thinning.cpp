#include "odometry/keypoints/thinning.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "odometry/map/cube_hash.hpp"

namespace mapless::inline v1 {
namespace {

// Returns from which the distribution of ranges is estimated. Chosen: the number of points selected is then
// right to 1 / sqrt(1021) = 3 %.
constexpr std::size_t kRangeSamples = 1021;

// Steps of the sine of the elevation per unit: half a degree at the horizon (180 deg / pi x 2).
constexpr float kElevationSteps = 115;

// Passes of pass_order. Measured: with a single pass, in the order of the returns, a hovering HDL-64E is
// unconstrained by the ground in 25 scans for 4, because cubes fill up with points of the lowest lasers; its
// velocity errs by 0.082 for 0.060 m/s.
constexpr std::size_t kPasses = 40;

// (sqrt(5) - 1) / 2; the search for a coprime step changes the digits after these.
constexpr double kGoldenSection = 0.618;

// A pseudo-random number in [0, 1) for return number i: the upper 24 of its hash's bits, the precision of a
// float.
float uniform(std::size_t i) {
  const auto bits = static_cast<std::uint32_t>(static_cast<std::uint64_t>(i) * kGoldenRatio64 >> 40);
  return static_cast<float>(bits) * 0x1p-24F;
}

// Interval of squared ranges of usable returns [m^2].
struct Ranges {
  explicit Ranges(const OdometryParameters& p)
      : nearest(static_cast<float>(p.min_range_m * p.min_range_m)),
        farthest(static_cast<float>(p.map_radius_m * p.map_radius_m)) {}
  float nearest, farthest;
  [[nodiscard]] bool contain(float square) const { return square >= nearest && square <= farthest; }
};

// The squared range beyond which all returns are used; 0 to use every return.
float thinning_limit(const LidarScan& scan, const Ranges& ranges, std::size_t max_points) {
  if (scan.returns.size() <= max_points) return 0;
  const std::size_t step = scan.returns.size() / kRangeSamples + 1;
  std::vector<float> squares;
  for (std::size_t i = 0; i < scan.returns.size(); i += step) {
    const float square = scan.returns[i].position_v.squaredNorm();
    if (ranges.contain(square)) squares.push_back(square);
  }
  const double target = static_cast<double>(max_points) / static_cast<double>(step);
  if (target >= static_cast<double>(squares.size())) return 0;
  return static_cast<float>(full_density_square(std::move(squares), target));
}

// If the recording does not number its lasers, points of the same elevation get the same number.
void assign_lasers_by_elevation(std::vector<ScanPoint>& points) {
  const bool numbered = std::any_of(points.begin(), points.end(),
                                    [&](const ScanPoint& p) { return p.laser != points.front().laser; });
  if (numbered) return;
  for (ScanPoint& p : points)
    p.laser = static_cast<std::int32_t>((p.position_v.z() / p.range_m + 1) * kElevationSteps);
}

}  // namespace

// If the k smallest squares are below r^2, then sum of these / r^2 + (size - k) = target. The left side
// decreases with r^2, so that the first k for which r^2 is at most the next square is the solution.
double full_density_square(std::vector<float> squares, double target) {
  std::sort(squares.begin(), squares.end());
  double sum = 0;
  for (std::size_t k = 1; k < squares.size(); ++k) {
    sum += squares[k - 1];
    const double left = target - static_cast<double>(squares.size() - k);
    if (left > 0 && sum <= left * squares[k]) return sum / left;
  }
  return (sum + squares.back()) / target;
}

std::vector<ScanPoint> thin(const LidarScan& scan, const OdometryParameters& parameters) {
  const Ranges ranges(parameters);
  const float limit = thinning_limit(scan, ranges, static_cast<std::size_t>(parameters.max_scan_points));
  std::vector<ScanPoint> out;
  out.reserve(std::min(scan.returns.size(), 2 * static_cast<std::size_t>(parameters.max_scan_points)));
  for (std::size_t i = 0; i < scan.returns.size(); ++i) {
    const LidarReturn& r = scan.returns[i];
    const float square = r.position_v.squaredNorm();
    if (ranges.contain(square) && uniform(i) * limit < square)
      out.push_back({r.position_v, std::sqrt(square), r.time_ns, r.laser, static_cast<std::uint32_t>(i)});
  }
  assign_lasers_by_elevation(out);
  for (std::size_t i = 0; i < out.size(); ++i) out[i].pass = static_cast<unsigned>(i % kPasses);
  return out;
}

std::vector<std::uint32_t> pass_order(std::size_t size) {
  std::vector<std::uint32_t> out;
  out.reserve(size);
  for (std::size_t pass = 0; pass < kPasses; ++pass) {
    for (std::size_t i = pass; i < size; i += kPasses) out.push_back(static_cast<std::uint32_t>(i));
  }
  return out;
}

std::vector<std::uint32_t> golden_order(std::size_t size) {
  std::vector<std::uint32_t> out;
  if (size == 0) return out;
  auto stride = static_cast<std::size_t>(kGoldenSection * static_cast<double>(size)) + 1;
  while (std::gcd(stride, size) != 1) ++stride;
  out.reserve(size);
  for (std::size_t i = 0; out.size() < size; i = i + stride < size ? i + stride : i + stride - size)
    out.push_back(static_cast<std::uint32_t>(i));
  return out;
}

}  // namespace mapless
