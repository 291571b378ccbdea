#include "oracle/ray_search_oracle.hpp"

#include <cmath>

#include <Eigen/Geometry>

namespace mapless::test {

using Eigen::Vector3d;

RaySearchOracle::RaySearchOracle(const LidarScan& scan, const Trajectory& trajectory)
    : scan_(scan), trajectory_(trajectory) {
  for (int laser = 0; laser < scan.rows(); ++laser) {
    for (int column = 0; column < scan.columns; ++column) {
      if (code_of_cell(scan.cell(laser, column)) != ReturnCode::absent) lines_.push_back(line(laser, column));
    }
  }
}

RaySearchOracle::Line RaySearchOracle::line(int laser, int column) const {
  const Duration offset = scan_.model->lasers[static_cast<std::size_t>(laser)].firing_offset;
  const SE3 T_0v = trajectory_.at(scan_.column_time(column) + offset).T_v0.inverse();
  const Vector3d start_v = scan_.model->point_v(laser, column, 0);
  const Vector3d direction_v = scan_.model->point_v(laser, column, 1) - start_v;
  return {laser, column, T_0v * start_v, (T_0v.rotation() * direction_v).normalized()};
}

OracleRay RaySearchOracle::nearest(const Vector3d& q_0) const {
  const Line* best = nullptr;
  double best_squared = 0;
  for (const Line& l : lines_) {
    const Vector3d r = q_0 - l.origin;
    const double foot = r.dot(l.direction);
    if (foot < 0) continue;
    const double squared = r.squaredNorm() - foot * foot;
    if (best == nullptr || squared < best_squared) {
      best = &l;
      best_squared = squared;
    }
  }
  return best == nullptr ? OracleRay{} : ray(best->laser, best->column, q_0);
}

OracleRay RaySearchOracle::ray(int laser, int column, const Vector3d& q_0) const {
  const Line l = line(laser, column);
  const Vector3d r = q_0 - l.origin;
  return {laser, column, r.cross(l.direction).norm(), r.dot(l.direction)};
}

Vector3d RaySearchOracle::direction_0(int laser, int column) const { return line(laser, column).direction; }
Vector3d RaySearchOracle::origin_0(int laser, int column) const { return line(laser, column).origin; }

}  // namespace mapless::test
