#include "odometry/keypoints/thinning.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace mapless::inline v1 {
namespace {

constexpr std::size_t kSample = 1021;  // returns that tell how ranges are distributed

constexpr float kElevationSteps = 115;  // half a degree each

constexpr std::size_t kPasses = 40;

// A number in [0, 1) for a return, as good as random.
float unit_of(std::size_t i) {
  const auto bits = static_cast<std::uint32_t>(static_cast<std::uint64_t>(i) * 0x9E3779B97F4A7C15u >> 40);
  return static_cast<float>(bits) * 0x1p-24F;
}

// Squared ranges of usable returns.
struct Ranges {
  explicit Ranges(const OdometryParameters& p)
      : nearest(static_cast<float>(p.min_range_m * p.min_range_m)),
        farthest(static_cast<float>(p.map_radius_m * p.map_radius_m)) {}
  float nearest, farthest;
  [[nodiscard]] bool have(float square) const { return square >= nearest && square <= farthest; }
};

// The squared range from which on all returns are used; 0 for all of them.
float full_square(const LidarScan& scan, const Ranges& ranges, std::size_t wanted) {
  if (scan.returns.size() <= wanted) return 0;
  const std::size_t step = scan.returns.size() / kSample + 1;
  std::vector<float> squares;
  for (std::size_t i = 0; i < scan.returns.size(); i += step) {
    const float square = scan.returns[i].position_v.squaredNorm();
    if (ranges.have(square)) squares.push_back(square);
  }
  const double target = static_cast<double>(wanted) / static_cast<double>(step);
  if (target >= static_cast<double>(squares.size())) return 0;
  return static_cast<float>(full_square_of(std::move(squares), target));
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

// With the first k below r^2, their sum / r^2 + the rest = target. The left side falls as r^2 grows: the
// first k whose r^2 is not beyond the next of them is right.
double full_square_of(std::vector<float> squares, double target) {
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
  const float full = full_square(scan, ranges, static_cast<std::size_t>(parameters.max_scan_points));
  std::vector<ScanPoint> out;
  out.reserve(std::min(scan.returns.size(), 2 * static_cast<std::size_t>(parameters.max_scan_points)));
  for (std::size_t i = 0; i < scan.returns.size(); ++i) {
    const LidarReturn& r = scan.returns[i];
    const float square = r.position_v.squaredNorm();
    if (ranges.have(square) && unit_of(i) * full < square)
      out.push_back({r.position_v, std::sqrt(square), r.time_ns, r.laser, static_cast<std::uint32_t>(i)});
  }
  tell_lasers_apart(out);
  for (std::size_t i = 0; i < out.size(); ++i) out[i].pass = static_cast<unsigned>(i % kPasses);
  return out;
}

std::vector<std::uint32_t> in_passes(std::size_t size) {
  std::vector<std::uint32_t> out;
  out.reserve(size);
  for (std::size_t pass = 0; pass < kPasses; ++pass) {
    for (std::size_t i = pass; i < size; i += kPasses) out.push_back(static_cast<std::uint32_t>(i));
  }
  return out;
}

std::vector<std::uint32_t> mixed_order(std::size_t size) {
  std::vector<std::uint32_t> out;
  if (size == 0) return out;
  auto stride = static_cast<std::size_t>(0.618 * static_cast<double>(size)) + 1;
  while (std::gcd(stride, size) != 1) ++stride;
  out.reserve(size);
  for (std::size_t i = 0; out.size() < size; i = i + stride < size ? i + stride : i + stride - size)
    out.push_back(static_cast<std::uint32_t>(i));
  return out;
}

}  // namespace mapless
