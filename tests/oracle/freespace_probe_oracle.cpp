#include "oracle/freespace_probe_oracle.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace mapless::test {
namespace {

using Eigen::Vector3d;

double known_range(const LidarScan& scan, int laser, int column) {
  const std::int32_t cell = scan.cell(laser, column);
  if (cell >= 0) return static_cast<double>(scan.returns[static_cast<std::size_t>(cell)].range_m);
  if (code_of_cell(cell) == ReturnCode::nothing) return scan.model->max_range_m;
  return std::numeric_limits<double>::quiet_NaN();
}

}  // namespace

FreespaceProbeOracle::FreespaceProbeOracle(const LidarScan& reference, const Trajectory& trajectory,
                                           const VotingParameters& parameters, const SurfaceSlopes& slopes)
    : reference_(reference), trajectory_(trajectory), parameters_(parameters), slopes_(slopes) {
  for (int l = 0; l < reference.rows(); ++l) {
    const Laser& laser = reference.model->lasers[static_cast<std::size_t>(l)];
    const SE3 T_hl = laser.T_lh().inverse();
    for (int c = 0; c < reference.columns; ++c) {
      const SE3 T_0v = trajectory.at(reference.column_time(c) + laser.firing_offset).T_v0.inverse();
      const SE3 T_vh(rotation_z(reference.model->hub_angle(c)), Vector3d::Zero());
      const SE3 T_0l = T_0v * T_vh * T_hl;
      rays_.push_back(
          {T_0l.translation(), T_0l.rotation().col(0), T_0l.rotation().col(2), known_range(reference, l, c)});
    }
  }
}

FreespaceProbeOracle::Sighting FreespaceProbeOracle::sight(const Vector3d& q_0, int laser, int first,
                                                           int end) const {
  Sighting best;
  double best_squared = std::numeric_limits<double>::infinity();
  for (int c = first; c < end; ++c) {
    const Ray& r = ray(laser, c);
    const Vector3d d = q_0 - r.origin;
    const double foot = d.dot(r.direction);
    const double squared = d.squaredNorm() - foot * foot;
    if (foot <= 0 || squared >= best_squared) continue;
    best_squared = squared;
    best = {laser, c, foot, d.dot(r.up), d.dot(r.up.cross(r.direction))};
  }
  return best;
}

double FreespaceProbeOracle::spacing_rad(int laser) const {
  const auto& lasers = reference_.model->lasers;
  double spacing = 0;
  for (int l = std::max(laser, 1); l <= std::min(laser + 1, reference_.rows() - 1); ++l) {
    const auto i = static_cast<std::size_t>(l);
    spacing = std::max(spacing, lasers[i].elevation_rad - lasers[i - 1].elevation_rad);
  }
  return spacing;
}

double FreespaceProbeOracle::tolerance_m(const Sighting& s) const {
  const double inclined_m =
      double{slopes_.up} * std::abs(s.height_m) + double{slopes_.left} * std::abs(s.left_m);
  return parameters_.tolerance_m +
         std::min(inclined_m, parameters_.tolerance_spacings * spacing_rad(s.laser) * s.range_m);
}

// The angle between two firings of a laser, about.
double FreespaceProbeOracle::aside_rad(const Sighting& s, int column) const {
  const double elevation_rad = reference_.model->lasers[static_cast<std::size_t>(s.laser)].elevation_rad;
  const double column_rad = 2 * std::numbers::pi / reference_.model->columns;
  return std::abs(column - s.column) * column_rad * std::cos(elevation_rad);
}

bool FreespaceProbeOracle::in_window(const Sighting& s, int column, double width_deg) const {
  const double column_rad = 2 * std::numbers::pi / reference_.model->columns;
  const double half_rad =
      std::max(parameters_.window_columns / 2 * column_rad, width_deg / 2 * std::numbers::pi / 180);
  return aside_rad(s, column) <= half_rad + 1e-9;
}

bool FreespaceProbeOracle::surface_beside(const Vector3d& q_0) const {
  for (const Sighting& s : around(q_0, 0, reference_.columns)) {
    for (int c = 0; c < reference_.columns; ++c) {
      if (in_window(s, c, parameters_.window_deg) || !in_window(s, c, parameters_.beside_window_deg))
        continue;
      if (std::abs(ray(s.laser, c).range_m - s.range_m) <= tolerance_m(s)) return true;
    }
  }
  return false;
}

FreespaceVerdict FreespaceProbeOracle::classify(const std::vector<Sighting>& around,
                                                const Sighting& nearest) const {
  bool ends_here = false, ends_short = false;
  for (const Sighting& s : around) {
    const double tolerance = tolerance_m(s);
    for (int c = 0; c < reference_.columns; ++c) {
      if (!in_window(s, c, parameters_.window_deg)) continue;
      const double beyond = ray(s.laser, c).range_m - s.range_m;
      ends_here = ends_here || std::abs(beyond) <= tolerance;
      const double column_rad = 2 * std::numbers::pi / reference_.model->columns;
      const bool hides = aside_rad(s, c) <= column_rad + 1e-9 || aside_rad(s, c) * s.range_m <= 0.12;
      ends_short = ends_short || (hides && beyond < -tolerance);
    }
  }
  if (ends_here) return FreespaceVerdict::border;
  const double range = ray(nearest.laser, nearest.column).range_m;
  if (std::isnan(range)) return FreespaceVerdict::unobserved;
  if (range < nearest.range_m) return FreespaceVerdict::outside;
  if (ends_short) return FreespaceVerdict::unobserved;
  const double edge_m = 0.1 * spacing_rad(nearest.laser) * nearest.range_m;
  const bool at_edge = around.size() < 2 && reference_.rows() > 1 && std::abs(nearest.height_m) > edge_m;
  return at_edge ? FreespaceVerdict::unobserved : FreespaceVerdict::inside;
}

std::vector<FreespaceProbeOracle::Sighting> FreespaceProbeOracle::around(const Vector3d& q_0, int first,
                                                                         int end) const {
  Sighting above, below;
  for (int l = 0; l < reference_.rows(); ++l) {
    const Sighting s = sight(q_0, l, first, end);
    if (s.laser < 0) continue;
    Sighting& side = s.height_m < 0 ? above : below;
    if (side.laser < 0 || std::abs(s.height_m) < std::abs(side.height_m)) side = s;
  }
  std::vector<Sighting> found;
  for (const Sighting& s : {above, below}) {
    if (s.laser >= 0) found.push_back(s);
  }
  return found;
}

FreespaceVerdict FreespaceProbeOracle::verdict(const Vector3d& q_0, int first, int end) const {
  const std::vector<Sighting> sides = around(q_0, first, end);
  if (sides.empty()) return FreespaceVerdict::unobserved;
  const Sighting nearest = *std::min_element(sides.begin(), sides.end(), [](const auto& a, const auto& b) {
    return std::abs(a.height_m) < std::abs(b.height_m);
  });
  const double reach = parameters_.max_ray_distance_m +
                       parameters_.max_ray_distance_spacings * spacing_rad(nearest.laser) * nearest.range_m;
  if (std::abs(nearest.height_m) > reach) return FreespaceVerdict::unobserved;
  return classify(sides, nearest);
}

double FreespaceProbeOracle::margin_m(const Vector3d& q_0, FreespaceVerdict other) const {
  for (double step = 0.0005; step < 0.3; step *= 2) {
    for (int direction = 0; direction < 27; ++direction) {
      const int x = direction % 3 - 1, y = direction / 3 % 3 - 1, z = direction / 9 - 1;
      const Vector3d d(x, y, z);
      if (d.isZero(0)) continue;
      if (verdict(q_0 + step * d.normalized()) == other) return step;
    }
  }
  return std::numeric_limits<double>::infinity();
}

double FreespaceProbeOracle::hub_angle_to(const Vector3d& q_0, int column) const {
  const Vector3d q_v = trajectory_.at(reference_.column_time(column)).T_v0 * q_0;
  const Vector3d q_h = rotation_z(-reference_.model->hub_angle(column)) * q_v;
  return std::abs(std::atan2(q_h.y(), q_h.x()));
}

double FreespaceProbeOracle::angle_from_seam(const Vector3d& q_0) const {
  return std::min(hub_angle_to(q_0, 0), hub_angle_to(q_0, reference_.columns - 1));
}

}  // namespace mapless::test
