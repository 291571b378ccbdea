#include <algorithm>
#include <cmath>
#include <optional>

#include "core/median.hpp"
#include "lidar/recovery/ring_points.hpp"

namespace mapless::inline v1 {
namespace {

// Rounds of reweighted least squares. Chosen: the weights no longer change in double precision long before.
constexpr int kIterations = 20;
// Rounding of clouds that are stored to a millimetre: residuals cannot be smaller.
constexpr double kSmallestScale_m = 5e-4;
// A line whose origin is less certain (one sigma) takes it from its neighbours. Chosen: at 5 m from the
// sensor, 0.01 m is 2 mrad, a third of the step between two lasers of an HDL-64E.
constexpr double kOriginAccuracy_m = 0.01;
// With fewer points the median absolute residual is no measure of their spread.
constexpr std::size_t kFewestPoints = 20;
// Standard deviation of a Gaussian over its median absolute value.
constexpr double kSigmaOverMedian = 1.4826;
// Points whose distances from the axis spread by less than 1 mm determine no slope.
constexpr double kLeastVariance_m2 = 1e-6;
// Share of the points that the residual leaves out: mixed returns at edges.
constexpr std::size_t kLeftOutOfResidual = 20;  // one in

struct Line {
  double slope = 0;
  double intercept = 0;
  double intercept_sigma = 0;  // if residuals were independent
};

double residual(const RingPoint& p, const Line& line) {
  return p.z_m - line.intercept - p.rho_m * line.slope;
}

double robust_scale(const RingPoints& points, const Line& line) {
  std::vector<double> sizes;
  sizes.reserve(points.size());
  for (const RingPoint& p : points) sizes.push_back(std::abs(residual(p, line)));
  return std::max(kSigmaOverMedian * median(std::move(sizes)), kSmallestScale_m);
}

// Least squares with Cauchy weights; nullopt if all points are at one distance.
std::optional<Line> weighted_line(const RingPoints& points, const Line& before, double scale) {
  double w_sum = 0;
  double rho = 0;
  double z = 0;
  std::vector<double> weights;
  weights.reserve(points.size());
  for (const RingPoint& p : points) {
    const double r = residual(p, before) / scale;
    weights.push_back(1 / (1 + r * r));
    w_sum += weights.back();
    rho += weights.back() * p.rho_m;
    z += weights.back() * p.z_m;
  }
  rho /= w_sum;
  z /= w_sum;
  double s_rr = 0;
  double s_rz = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    s_rr += weights[i] * (points[i].rho_m - rho) * (points[i].rho_m - rho);
    s_rz += weights[i] * (points[i].rho_m - rho) * (points[i].z_m - z);
  }
  if (s_rr < kLeastVariance_m2 * w_sum) return std::nullopt;
  Line line;
  line.slope = s_rz / s_rr;
  line.intercept = z - line.slope * rho;
  line.intercept_sigma = scale * std::sqrt(1 / w_sum + rho * rho / s_rr);
  return line;
}

// Median slope for a given origin: a start that outliers do not move.
double median_slope(const RingPoints& points, double intercept) {
  std::vector<double> slopes;
  slopes.reserve(points.size());
  for (const RingPoint& p : points) slopes.push_back((p.z_m - intercept) / p.rho_m);
  return median(std::move(slopes));
}

std::optional<Line> robust_line(const RingPoints& points) {
  if (points.size() < kFewestPoints) return std::nullopt;
  Line line{median_slope(points, 0), 0, 0};
  for (int i = 0; i < kIterations; ++i) {
    const std::optional<Line> next = weighted_line(points, line, robust_scale(points, line));
    if (!next) return std::nullopt;
    line = *next;
  }
  if (line.intercept_sigma > kOriginAccuracy_m) return std::nullopt;
  return line;
}

// Value at ring i, interpolated between the nearest rings that have one; `fallback` if none has.
template <class Read>
double interpolated(const std::vector<bool>& has, std::size_t i, double fallback, Read read) {
  std::optional<std::size_t> below;
  std::optional<std::size_t> above;
  for (std::size_t k = 0; k < has.size(); ++k) {
    if (!has[k]) continue;
    if (k < i) below = k;
    if (k > i && !above) above = k;
  }
  if (!below && !above) return fallback;
  if (!below) return read(*above);
  if (!above) return read(*below);
  const double share = static_cast<double>(i - *below) / static_cast<double>(*above - *below);
  return (1 - share) * read(*below) + share * read(*above);
}

}  // namespace

std::vector<RingLine> fit_ring_lines(const std::vector<RingPoints>& rings) {
  std::vector<RingLine> lines(rings.size());
  std::vector<bool> has_origin(rings.size(), false);
  for (std::size_t i = 0; i < rings.size(); ++i) {
    const std::optional<Line> line = robust_line(rings[i]);
    lines[i].borrowed = !line;
    if (!line) continue;
    lines[i].elevation_rad = std::atan(line->slope);
    lines[i].origin_z_m = line->intercept;
    has_origin[i] = true;
  }
  std::vector<bool> has_elevation = has_origin;
  for (std::size_t i = 0; i < rings.size(); ++i) {
    if (has_origin[i]) continue;
    lines[i].origin_z_m = interpolated(has_origin, i, 0, [&](std::size_t k) { return lines[k].origin_z_m; });
    if (rings[i].empty()) continue;
    lines[i].elevation_rad = std::atan(median_slope(rings[i], lines[i].origin_z_m));
    has_elevation[i] = true;
  }
  for (std::size_t i = 0; i < rings.size(); ++i) {
    if (has_elevation[i]) continue;
    lines[i].elevation_rad =
        interpolated(has_elevation, i, 0, [&](std::size_t k) { return lines[k].elevation_rad; });
  }
  return lines;
}

double ring_line_residual(const std::vector<RingPoints>& rings, const std::vector<RingLine>& lines) {
  std::vector<double> squares;
  for (std::size_t i = 0; i < rings.size(); ++i) {
    const Line line{std::tan(lines[i].elevation_rad), lines[i].origin_z_m, 0};
    for (const RingPoint& p : rings[i]) squares.push_back(residual(p, line) * residual(p, line));
  }
  if (squares.empty()) return 0;
  const std::size_t kept = std::max<std::size_t>(1, squares.size() - squares.size() / kLeftOutOfResidual);
  std::nth_element(squares.begin(), squares.begin() + static_cast<std::ptrdiff_t>(kept - 1), squares.end());
  double sum = 0;
  for (std::size_t i = 0; i < kept; ++i) sum += squares[i];
  return std::sqrt(sum / static_cast<double>(kept));
}

}  // namespace mapless
