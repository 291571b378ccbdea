#include "oracle/freespace_oracle.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace mapless::test {
namespace {

using Eigen::Vector3d;

/// Compares lengths, and remembers the closest call.
class Comparer {
 public:
  bool exceeds(double a, double b) {
    margin_ = std::min(margin_, std::abs(a - b));
    return a > b;
  }
  [[nodiscard]] OracleFreespace answer(FreespaceVerdict verdict) const { return {verdict, margin_}; }

 private:
  double margin_ = std::numeric_limits<double>::infinity();
};

/// Where the end of a ray lies with respect to the plane of q, or with respect to q itself where it has no
/// normal or where the ray starts on its plane and so runs along it.
FreespaceVerdict against_end(const Vector3d& q, const Vector3d& n, const Vector3d& origin,
                             const Vector3d& end, double foot_range, double threshold, Comparer& compare) {
  if (!n.isZero(0) && compare.exceeds(std::abs(n.dot(origin - q)), threshold)) {
    if (!compare.exceeds(std::abs(n.dot(end - q)), threshold)) return FreespaceVerdict::border;
    const bool through = (n.dot(end - q) > 0) != (n.dot(origin - q) > 0);
    return through ? FreespaceVerdict::inside : FreespaceVerdict::outside;
  }
  if (!compare.exceeds((end - q).norm(), threshold)) return FreespaceVerdict::border;
  return compare.exceeds((end - origin).norm(), foot_range) ? FreespaceVerdict::inside
                                                            : FreespaceVerdict::outside;
}

}  // namespace

FreespaceOracle::FreespaceOracle(const LidarScan& reference, const Trajectory& trajectory)
    : reference_(reference), rays_(reference, trajectory) {
  for (const LidarReturn& r : reference.returns)
    endpoints_0_.push_back(trajectory.at(reference.time_of(r)).T_v0.inverse() * r.position_v.cast<double>());
}

double FreespaceOracle::spacing_at(int laser) const {
  const std::vector<Laser>& lasers = reference_.model->lasers;
  double spacing = 0;
  for (std::size_t l = 1; l < lasers.size(); ++l)
    if (static_cast<int>(l) == laser || static_cast<int>(l) == laser + 1)
      spacing = std::max(spacing, lasers[l].elevation_rad - lasers[l - 1].elevation_rad);
  return spacing;
}

int FreespaceOracle::image_column(int laser, int column) const {
  const LidarModel& model = *reference_.model;
  const double columns_per_rad = model.sign() * model.columns / (2 * std::numbers::pi);
  const double shift = model.lasers[static_cast<std::size_t>(laser)].azimuth_offset_rad * columns_per_rad;
  return column + static_cast<int>(std::lround(shift));
}

OracleFreespace FreespaceOracle::verdict(const Vector3d& q, const Vector3d& normal, double threshold_m,
                                         const FreespaceParameters& p) const {
  Comparer compare;
  const OracleRay ray = rays_.nearest(q);
  if (ray.laser < 0) return compare.answer(FreespaceVerdict::unobserved);
  const double limit =
      p.max_ray_distance_m + p.max_ray_distance_spacings * spacing_at(ray.laser) * ray.range_m;
  if (p.require_near_ray && compare.exceeds(ray.distance_m, limit))
    return compare.answer(FreespaceVerdict::unobserved);

  const double radius = threshold_m + p.border_radius_per_m * ray.range_m;
  const bool windowed = p.border_window_rows > 1 || p.border_window_columns > 1;
  const int centre = image_column(ray.laser, ray.column);
  for (std::size_t i = 0; windowed && i < endpoints_0_.size(); ++i) {
    const LidarReturn& r = reference_.returns[i];
    const int apart = std::abs(image_column(r.laser, r.column) - centre) % reference_.columns;
    if (std::abs(r.laser - ray.laser) > p.border_window_rows / 2) continue;
    if (std::min(apart, reference_.columns - apart) > p.border_window_columns / 2) continue;
    if (!compare.exceeds((endpoints_0_[i] - q).norm(), radius))
      return compare.answer(FreespaceVerdict::border);
  }
  const std::int32_t cell = reference_.cell(ray.laser, ray.column);
  if (cell >= 0)
    return compare.answer(against_end(q, normal, rays_.origin_0(ray.laser, ray.column),
                                      endpoints_0_[static_cast<std::size_t>(cell)], ray.range_m, threshold_m,
                                      compare));
  const bool free = code_of_cell(cell) == ReturnCode::nothing && p.no_return_is_free &&
                    !compare.exceeds(ray.range_m, reference_.model->max_range_m);
  return compare.answer(free ? FreespaceVerdict::inside : FreespaceVerdict::unobserved);
}

}  // namespace mapless::test
