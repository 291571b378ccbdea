#include "detection/published/ray_search.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

namespace mapless::inline v1 {
namespace {

// Enough for a sensor turning at half its spin rate: each iteration multiplies the error by the ratio of the
// two.
constexpr int kMaxIterations = 12;

bool nearer(const NearestRay& a, const NearestRay& b) { return a.distance_m < b.distance_m; }

}  // namespace

RaySearch::RaySearch(const CompensatedScan& scan) : scan_(scan) {
  const LidarModel& model = *scan.scan->model;
  columns_per_rad_ = model.sign() * model.columns / (2 * std::numbers::pi);
  const double period_s = scan.scan->column_period.seconds();
  for (const Laser& laser : model.lasers) {
    laser_T_lh_.push_back(laser.T_lh());
    firing_s_.push_back(laser.firing_offset.seconds());
    // A beam ahead of the hub (in the direction of spin) points somewhere at an earlier column.
    offset_columns_.push_back(-laser.azimuth_offset_rad * columns_per_rad_);
    max_offset_columns_ = std::max(max_offset_columns_, std::abs(offset_columns_.back()));
    max_offset_s_ = std::max(max_offset_s_, std::abs(offset_columns_.back()) * period_s + firing_s_.back());
    centre_h_ += laser.origin_h_m / static_cast<double>(model.lasers.size());
  }
  for (const Laser& laser : model.lasers) {
    cones_.push_back({std::cos(laser.elevation_rad), std::sin(laser.elevation_rad), laser.origin_h_m.z(),
                      laser.origin_h_m.head<2>().norm()});
    origin_spread_m_ = std::max(origin_spread_m_, (laser.origin_h_m - centre_h_).norm());
  }
  column_T_h0_.reserve(scan.column_states.size());
  column_varpi_h_.reserve(scan.column_states.size());
  for (std::size_t c = 0; c < scan.column_states.size(); ++c) {
    const SE3 T_hv(rotation_z(-model.hub_angle(static_cast<double>(c))), Eigen::Vector3d::Zero());
    const TrajectoryState& state = scan.column_states[c];
    column_T_h0_.push_back(T_hv * state.T_v0);
    Vector6d varpi_h;
    varpi_h << T_hv.rotation() * state.varpi.head<3>(), T_hv.rotation() * state.varpi.tail<3>();
    column_varpi_h_.push_back(varpi_h);
    travel_m_ += state.varpi.head<3>().norm() * period_s;
    turn_rad_ += state.varpi.tail<3>().norm() * period_s;
  }
}

RaySearch::Sighting RaySearch::sight(const Eigen::Vector3d& q_0, int laser, int column) const {
  const auto c = static_cast<std::size_t>(column);
  const auto l = static_cast<std::size_t>(laser);
  Eigen::Vector3d q_h = column_T_h0_[c] * q_0;
  // Between the column's instant and its own the laser goes along with the sensor, to first order. Its turn
  // with the hub is part of its azimuth offset.
  if (firing_s_[l] != 0) {
    const Vector6d& varpi_h = column_varpi_h_[c];
    q_h += firing_s_[l] * (varpi_h.head<3>() + varpi_h.tail<3>().cross(q_h));
  }
  const Eigen::Vector3d q_l = laser_T_lh_[l] * q_h;
  // The hub has to turn until y vanishes; about its axis the point moves on a circle of its horizontal
  // distance.
  const double horizontal = std::max(q_h.head<2>().norm(), 1e-9);
  const double turn = q_l.x() > 0 ? std::clamp(q_l.y() / horizontal, -1.0, 1.0) : 0.0;
  return {column, q_h, q_l, column + turn * columns_per_rad_};
}

double RaySearch::column_of_direction(const Eigen::Vector3d& q_0) const {
  const int columns = scan_.scan->columns;
  double column = 0;
  for (int i = 0; i < kMaxIterations; ++i) {
    const Eigen::Vector3d q_h = column_T_h0_[static_cast<std::size_t>(clamped_column(column))] * q_0;
    const double next = clamped_column(column) + std::atan2(q_h.y(), q_h.x()) * columns_per_rad_;
    const double wrapped = next - columns * std::floor(next / columns);
    if (std::abs(wrapped - column) < 0.5) return wrapped;
    column = wrapped;
  }
  return column;
}

int RaySearch::clamped_column(double column) const {
  return static_cast<int>(std::clamp(std::round(column), 0.0, scan_.scan->columns - 1.0));
}

int RaySearch::laser_of_elevation(double elevation_rad) const {
  const auto& lasers = scan_.scan->model->lasers;
  const auto above = std::lower_bound(lasers.begin(), lasers.end(), elevation_rad,
                                      [](const Laser& l, double e) { return l.elevation_rad < e; });
  if (above == lasers.begin()) return 0;
  const auto found = static_cast<int>(above - lasers.begin());
  if (above == lasers.end()) return found - 1;
  const bool lower_is_closer =
      elevation_rad - std::prev(above)->elevation_rad < above->elevation_rad - elevation_rad;
  return lower_is_closer ? found - 1 : found;
}

NearestRay RaySearch::measured_ray(const Eigen::Vector3d& q_0, int laser, int column) const {
  if (column < 0 || column >= scan_.scan->columns) return {};
  return measured_ray(sight(q_0, laser, column), laser);
}

NearestRay RaySearch::measured_ray(const Sighting& s, int laser) const {
  if (code_of_cell(scan_.scan->cell(laser, s.at)) == ReturnCode::absent || s.q_l.x() <= 0) return {};
  return {laser, s.at, s.q_l.tail<2>().norm(), s.q_l.x()};
}

// Of the measured rays of the laser from the point, by where it lies from the cone of the beams in this
// column: from column to column it moves with the sensor, apart from its circle about the hub's axis.
double RaySearch::least_distance(const Sighting& s, int laser) const {
  const Cone& cone = cones_[static_cast<std::size_t>(laser)];
  const Vector6d& varpi_h = column_varpi_h_[static_cast<std::size_t>(s.at)];
  const double columns = 2 * std::abs(s.column - s.at) + kColumnReach + 2;
  const double speed = varpi_h.head<3>().norm() + varpi_h.segment<2>(3).norm() * s.q_h.norm();
  const double moved_m = columns * scan_.scan->column_period.seconds() * speed;
  return std::abs(s.q_h.head<2>().norm() * cone.sine - (s.q_h.z() - cone.height_m) * cone.cosine) -
         cone.beside_m - moved_m;
}

NearestRay RaySearch::nearest_of_laser(const Eigen::Vector3d& q_0, int laser, double hub_column,
                                       const NearestRay& known) const {
  Sighting s =
      sight(q_0, laser, clamped_column(hub_column + offset_columns_[static_cast<std::size_t>(laser)]));
  if (least_distance(s, laser) > known.distance_m) return {};
  for (int i = 0; i < kMaxIterations && clamped_column(s.column) != s.at; ++i) {
    s = sight(q_0, laser, clamped_column(s.column));
  }
  NearestRay best = measured_ray(s, laser);
  for (int reach = 1; s.q_l.x() > 0 && !best.found() && reach <= kColumnReach; ++reach) {
    for (const int column : {s.at - reach, s.at + reach}) {
      const NearestRay ray = measured_ray(q_0, laser, column);
      if (nearer(ray, best)) best = ray;
    }
  }
  if (!best.found()) return best;
  // The sensor's own motion makes columns wider or narrower than the hub's turn alone, so that the one the
  // solution rounds to need not be the nearest.
  for (const int step : {-1, 1}) {
    NearestRay next = measured_ray(q_0, laser, best.column + step);
    while (nearer(next, best)) {
      best = next;
      next = measured_ray(q_0, laser, best.column + step);
    }
  }
  return best;
}

void RaySearch::descend(const Eigen::Vector3d& q_0, double hub_column, NearestRay& best) const {
  const auto at = static_cast<std::size_t>(clamped_column(hub_column));
  const Eigen::Vector3d from_centre = column_T_h0_[at] * q_0 - centre_h_;
  const double range = from_centre.norm();
  const double elevation = std::atan2(from_centre.z(), from_centre.head<2>().norm());
  // A beam passes the centre at its laser's offset, and fires when the sensor has moved a little: it cannot
  // come nearer than this.
  const Vector6d& varpi_h = column_varpi_h_[at];
  const double moved_m = max_offset_s_ * (varpi_h.head<3>().norm() + varpi_h.segment<2>(3).norm() * range);
  const auto& lasers = scan_.scan->model->lasers;
  const auto least_distance = [&](int l) {
    const double apart = std::abs(lasers[static_cast<std::size_t>(l)].elevation_rad - elevation);
    return range * std::sin(std::min(apart, std::numbers::pi / 2)) - origin_spread_m_ - moved_m;
  };
  const int start = laser_of_elevation(elevation);
  const auto look_from = [&](int first, int step) {
    for (int l = first; l >= 0 && l < static_cast<int>(lasers.size()); l += step) {
      if (least_distance(l) > best.distance_m) return;
      const NearestRay ray = nearest_of_laser(q_0, l, hub_column, best);
      if (nearer(ray, best)) best = ray;
    }
  };
  look_from(start, -1);
  look_from(start + 1, +1);
}

double RaySearch::longest_range(const Eigen::Vector3d& q_0) const {
  if (column_T_h0_.empty()) return 0;
  return (column_T_h0_.front() * q_0 - centre_h_).norm() + origin_spread_m_ + travel_m_;
}

NearestRay RaySearch::nearest(const Eigen::Vector3d& q_0, double limit_m) const {
  NearestRay best;
  best.distance_m = limit_m;  // of no laser: only a nearer ray counts
  if (column_T_h0_.empty() || laser_T_lh_.empty() || !q_0.allFinite()) return {};
  const int columns = scan_.scan->columns;
  const double column = column_of_direction(q_0);
  descend(q_0, column, best);
  // Near the seam a direction occurs twice, at the start and at the end of the scan. How near depends on the
  // lasers' azimuth offsets and on how far the point wandered about the sensor meanwhile.
  const double distance =
      (column_T_h0_[static_cast<std::size_t>(clamped_column(column))] * q_0).head<2>().norm();
  const double wandered = std::abs(columns_per_rad_) * (turn_rad_ + travel_m_ / std::max(distance, 1e-9));
  const double seam = std::min(max_offset_columns_ + wandered + 2, columns / 2.0);
  if (column < seam) descend(q_0, column + columns, best);
  if (column > columns - seam) descend(q_0, column - columns, best);
  return best.found() ? best : NearestRay{};
}

}  // namespace mapless
