#include "detection/freespace/object_sight.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <Eigen/Geometry>

namespace mapless::inline v1 {
namespace {

using Eigen::Vector3d;

// How far beyond a place a ray must end: more than the shape of an object and its turn between two scans
// explain. Chosen.
constexpr double kMinBeyond_m = 0.5, kMinBeyondPerMetre = 0.01;
constexpr int kMinRays = 3;  // of the four around the place; one may be faulty

double azimuth_of(const Vector3d& p_v) { return std::atan2(p_v.y(), p_v.x()); }

}  // namespace

SightLines::SightLines(std::shared_ptr<const LidarScan> scan, const TrajectoryState& state, Time time)
    : scan_(std::move(scan)), state_(state), t_s_((time - scan_->start).seconds()) {}

double SightLines::column_of(double azimuth_rad, double azimuth_offset_rad) const {
  const LidarModel& model = *scan_->model;
  const double turn = 2 * std::numbers::pi;
  const double hub_angle = azimuth_rad - azimuth_offset_rad - model.start_azimuth_rad;
  const double share = model.sign() * hub_angle / turn;
  return (share - std::floor(share)) * model.columns;
}

Vector3d SightLines::in_sensor(const Vector3d& p_0) const {
  const Vector3d near = state_.T_v0 * p_0;
  const double period_s = scan_->column_period.seconds();
  const double dt = column_of(azimuth_of(near), 0) * period_s - t_s_;
  const double turn_s = period_s * scan_->columns;
  // Beside the seam the direction was observed a turn before or after the instant of the state.
  if (std::abs(dt) > turn_s / 2) return near;
  return near + dt * (state_.varpi.head<3>() + state_.varpi.tail<3>().cross(near));
}

bool SightLines::through(const Vector3d& p_0) const {
  const Vector3d p_v = in_sensor(p_0);
  const double range = p_v.norm();
  const auto& lasers = scan_->model->lasers;
  const double elevation = std::asin(std::clamp(p_v.z() / std::max(range, 1e-6), -1.0, 1.0));
  const auto above = std::partition_point(lasers.begin(), lasers.end(), [elevation](const Laser& laser) {
    return laser.elevation_rad < elevation;
  });
  if (above == lasers.begin() || above == lasers.end()) return false;
  const int upper = static_cast<int>(above - lasers.begin());
  const double azimuth = azimuth_of(p_v);
  int rays = 0;
  for (const int row : {upper - 1, upper}) {
    const double column = column_of(azimuth, lasers[static_cast<std::size_t>(row)].azimuth_offset_rad);
    const int first = static_cast<int>(std::floor(column));
    for (const int c : {first % scan_->model->columns, (first + 1) % scan_->model->columns}) {
      if (c >= scan_->columns) continue;
      const std::int32_t cell = scan_->cell(row, c);
      if (cell < 0 && code_of_cell(cell) != ReturnCode::nothing) continue;
      ++rays;
      if (cell < 0) continue;
      const double measured = static_cast<double>(scan_->returns[static_cast<std::size_t>(cell)].range_m);
      if (measured < range + kMinBeyond_m + kMinBeyondPerMetre * range) return false;
    }
  }
  return rays >= kMinRays;
}

}  // namespace mapless
