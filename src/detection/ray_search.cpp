#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

#include <mapless/detection/ray_search.hpp>

namespace mapless {
namespace {

// Enough for a sensor turning at half its spin rate: each iteration multiplies the error by the ratio of the
// two.
constexpr int kMaxIterations = 12;

bool nearer(const NearestRay& a, const NearestRay& b) {
  return a.found() && (!b.found() || a.distance_m < b.distance_m);
}

}  // namespace

RaySearch::RaySearch(const CompensatedScan& scan, int look_ahead) : scan_(scan), look_ahead_(look_ahead) {
  const LidarModel& model = *scan.scan->model;
  columns_per_rad_ = model.sign() * model.columns / (2 * std::numbers::pi);
  for (const Laser& laser : model.lasers) {
    laser_T_lh_.push_back(laser.T_lh());
    // A beam ahead of the hub (in the direction of spin) points somewhere at an earlier column.
    offset_columns_.push_back(-laser.azimuth_offset_rad * columns_per_rad_);
  }
  for (const Laser& laser : model.lasers)
    centre_h_ += laser.origin_h_m / static_cast<double>(model.lasers.size());
  for (const Laser& laser : model.lasers) {
    origin_spread_m_ = std::max(origin_spread_m_, (laser.origin_h_m - centre_h_).norm());
  }
  column_T_h0_.reserve(scan.column_states.size());
  for (std::size_t c = 0; c < scan.column_states.size(); ++c) {
    const SE3 T_hv(rotation_z(-model.hub_angle(static_cast<double>(c))), Eigen::Vector3d::Zero());
    const TrajectoryState& state = scan.column_states[c];
    column_T_h0_.push_back(T_hv * state.T_v0);
    column_varpi_h_.emplace_back();
    column_varpi_h_.back() << T_hv.rotation() * state.varpi.head<3>(),
        T_hv.rotation() * state.varpi.tail<3>();
  }
}

RaySearch::Sighting RaySearch::sight(const Eigen::Vector3d& q_0, int laser, int column) const {
  const SE3& T_lh = laser_T_lh_[static_cast<std::size_t>(laser)];
  const auto c = static_cast<std::size_t>(column);
  const Eigen::Vector3d q_h = column_T_h0_[c] * q_0;
  // Between the column's instant and its own the laser goes along with the sensor, to first order. Its turn
  // with the hub is part of its azimuth offset.
  const double firing_s = scan_.scan->model->lasers[static_cast<std::size_t>(laser)].firing_offset.seconds();
  const Vector6d& varpi_h = column_varpi_h_[c];
  const Eigen::Vector3d q_l =
      T_lh * (firing_s == 0
                  ? q_h
                  : Eigen::Vector3d(q_h + firing_s * (varpi_h.head<3>() + varpi_h.tail<3>().cross(q_h))));
  // The hub has to turn until y vanishes; about its axis the point moves on a circle of its horizontal
  // distance.
  const double horizontal = std::hypot(q_h.x(), q_h.y());
  const double turn =
      q_l.x() > 0 ? std::asin(std::clamp(q_l.y() / std::max(horizontal, 1e-9), -1.0, 1.0)) : 0.0;
  return {q_l, column + turn * columns_per_rad_};
}

double RaySearch::column_of_direction(const Eigen::Vector3d& q_0) const {
  const int columns = scan_.scan->columns;
  double column = 0;
  for (int i = 0; i < kMaxIterations; ++i) {
    const int at = std::clamp(static_cast<int>(std::lround(column)), 0, columns - 1);
    const Eigen::Vector3d q_h = column_T_h0_[static_cast<std::size_t>(at)] * q_0;
    const double next = at + std::atan2(q_h.y(), q_h.x()) * columns_per_rad_;
    const double wrapped = next - columns * std::floor(next / columns);
    if (std::abs(wrapped - column) < 0.5) return wrapped;
    column = wrapped;
  }
  return column;
}

int RaySearch::laser_of_direction(const Eigen::Vector3d& q_0, int column) const {
  const auto& lasers = scan_.scan->model->lasers;
  const Eigen::Vector3d q_h = column_T_h0_[static_cast<std::size_t>(column)] * q_0;
  const double horizontal = std::hypot(q_h.x(), q_h.y());
  std::size_t found = lasers.size() / 2;
  // Twice: the first laser found tells from how high the second look has to be.
  for (int i = 0; i < 2; ++i) {
    const double elevation = std::atan2(q_h.z() - lasers[found].origin_h_m.z(), horizontal);
    const auto above = std::lower_bound(lasers.begin(), lasers.end(), elevation,
                                        [](const Laser& l, double e) { return l.elevation_rad < e; });
    found = static_cast<std::size_t>(above - lasers.begin());
    if (found == lasers.size()) --found;
    if (found > 0 && elevation - lasers[found - 1].elevation_rad < lasers[found].elevation_rad - elevation) {
      --found;
    }
  }
  return static_cast<int>(found);
}

NearestRay RaySearch::measured_ray(const Eigen::Vector3d& q_0, int laser, int column) const {
  const LidarScan& scan = *scan_.scan;
  if (column < 0 || column >= scan.columns) return {};
  if (code_of_cell(scan.cell(laser, column)) == ReturnCode::absent) return {};
  const Eigen::Vector3d q_l = sight(q_0, laser, column).q_l;
  if (q_l.x() <= 0) return {};
  return {laser, column, std::hypot(q_l.y(), q_l.z()), q_l.x()};
}

// The measured ray of one laser nearest to the point, from the column that its solution rounds to. The
// sensor's own motion makes the columns wider or narrower than the solution took them for, so that a
// neighbour may be nearer.
NearestRay RaySearch::nearest_about(const Eigen::Vector3d& q_0, int laser, int column) const {
  NearestRay best = measured_ray(q_0, laser, column);
  for (int reach = 1; !best.found() && reach <= kColumnReach; ++reach) {
    for (const int c : {column - reach, column + reach}) {
      const NearestRay ray = measured_ray(q_0, laser, c);
      if (nearer(ray, best)) best = ray;
    }
  }
  if (!best.found()) return best;
  for (const int step : {-1, 1}) {
    NearestRay next = measured_ray(q_0, laser, best.column + step);
    while (nearer(next, best)) {
      best = next;
      next = measured_ray(q_0, laser, best.column + step);
    }
  }
  return best;
}

NearestRay RaySearch::nearest_of_laser(const Eigen::Vector3d& q_0, int laser, double hub_column) const {
  const int columns = scan_.scan->columns;
  const auto clamped = [columns](double c) {
    return static_cast<int>(std::clamp(std::round(c), 0.0, columns - 1.0));
  };
  int column = clamped(hub_column + offset_columns_[static_cast<std::size_t>(laser)]);
  for (int i = 0; i < kMaxIterations; ++i) {
    const int next = clamped(sight(q_0, laser, column).column);
    if (next == column) break;
    column = next;
  }
  return nearest_about(q_0, laser, column);
}

void RaySearch::descend(const Eigen::Vector3d& q_0, double hub_column, NearestRay& best) const {
  const int lasers = static_cast<int>(laser_T_lh_.size());
  const int columns = scan_.scan->columns;
  const int at = static_cast<int>(std::clamp(std::round(hub_column), 0.0, columns - 1.0));
  const int start = laser_of_direction(q_0, at);
  const Eigen::Vector3d from_centre = column_T_h0_[static_cast<std::size_t>(at)] * q_0 - centre_h_;
  const double range = from_centre.norm();
  const double elevation = std::atan2(from_centre.z(), std::hypot(from_centre.x(), from_centre.y()));
  // A beam passes its laser's offset from the centre, so it cannot come nearer than this.
  const auto least_distance = [&](int l) {
    const double apart =
        std::abs(scan_.scan->model->lasers[static_cast<std::size_t>(l)].elevation_rad - elevation);
    return range * std::sin(std::min(apart, std::numbers::pi / 2)) - origin_spread_m_;
  };
  NearestRay nearest = nearest_of_laser(q_0, start, hub_column);
  for (const int step : {-1, 1}) {
    int without_gain = 0;
    for (int l = start + step; l >= 0 && l < lasers && without_gain < look_ahead_; l += step) {
      const NearestRay ray = nearest_of_laser(q_0, l, hub_column);
      if (nearer(ray, nearest)) {
        nearest = ray;
        without_gain = 0;
      } else if (nearest.found() && least_distance(l) > nearest.distance_m) {
        ++without_gain;
      }
    }
  }
  if (nearer(nearest, best)) best = nearest;
}

NearestRay RaySearch::nearest(const Eigen::Vector3d& q_0) const {
  NearestRay best;
  if (column_T_h0_.empty() || laser_T_lh_.empty() || !q_0.allFinite()) return best;
  const int columns = scan_.scan->columns;
  const double column = column_of_direction(q_0);
  descend(q_0, column, best);
  // Near the seam a direction occurs twice, at the start and at the end of the scan. How near depends on the
  // lasers' azimuth offsets and on how far the sensor turned meanwhile.
  const double seam = columns / 4.0;
  if (column < seam) descend(q_0, column + columns, best);
  if (column > columns - seam) descend(q_0, column - columns, best);
  return best;
}

}  // namespace mapless
