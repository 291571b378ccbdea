#include "simulation/traffic/path.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

namespace mapless::inline v1 {

using Eigen::Vector2d;
using Eigen::Vector3d;

Path::Path(const std::vector<Vector2d>& waypoints) {
  points_.push_back(waypoints.front());
  double into = kStep;  // of the next point from the segment's start
  for (std::size_t i = 0; i + 1 < waypoints.size(); ++i) {
    const Vector2d along = waypoints[i + 1] - waypoints[i];
    const double length = along.norm();
    for (; into <= length; into += kStep) points_.emplace_back(waypoints[i] + along * (into / length));
    into -= length;
  }
  if (points_.size() < 2) points_.push_back(waypoints.back());
}

Vector2d Path::point(long i) const {
  const long last = static_cast<long>(points_.size()) - 1;
  if (i < 0) return points_[0] + static_cast<double>(i) * (points_[1] - points_[0]);
  if (i > last) {
    const Vector2d& end = points_.back();
    return end + static_cast<double>(i - last) * (end - points_[points_.size() - 2]);
  }
  return points_[static_cast<std::size_t>(i)];
}

// Catmull-Rom through the points.
Vector2d Path::at(double s) const {
  const double cell = std::floor(s / kStep);
  const double u = s / kStep - cell;
  const long i = static_cast<long>(cell);
  const Vector2d p0 = point(i - 1);
  const Vector2d p1 = point(i);
  const Vector2d p2 = point(i + 1);
  const Vector2d p3 = point(i + 2);
  return 0.5 * (2 * p1 + (p2 - p0) * u + (2 * p0 - 5 * p1 + 4 * p2 - p3) * u * u +
                (3 * p1 - p0 - 3 * p2 + p3) * u * u * u);
}

Vector2d Path::heading(double s, double span_m) const {
  return (at(s + span_m / 2) - at(s - span_m / 2)).normalized();
}

SE3 pose_on_ground(const Vector2d& p, const Vector2d& heading, const Terrain& terrain) {
  constexpr double kReach = 0.5;
  const double dx = terrain(p.x() + kReach, p.y()) - terrain(p.x() - kReach, p.y());
  const double dy = terrain(p.x(), p.y() + kReach) - terrain(p.x(), p.y() - kReach);
  const Vector3d up = Vector3d(-dx, -dy, 2 * kReach).normalized();
  const Vector3d left = up.cross(Vector3d(heading.x(), heading.y(), 0)).normalized();
  Eigen::Matrix3d rotation;
  rotation << left.cross(up), left, up;
  return {rotation, {p.x(), p.y(), terrain(p.x(), p.y())}};
}

double Track::distance_m(double t_s) const {
  const double last = static_cast<double>(s_.size() - 1);
  const double k = std::clamp(std::floor(t_s / kStep_s), 0.0, last);
  const auto i = static_cast<std::size_t>(k);
  const double dt = t_s - k * kStep_s;
  const double a = i + 1 < v_.size() && dt > 0 ? (v_[i + 1] - v_[i]) / kStep_s : 0;
  return s_[i] + v_[i] * dt + a * dt * dt / 2;
}

double Track::speed(double t_s) const {
  const double last = static_cast<double>(s_.size() - 1);
  const double k = std::clamp(std::floor(t_s / kStep_s), 0.0, last);
  const auto i = static_cast<std::size_t>(k);
  const double a = i + 1 < v_.size() ? (v_[i + 1] - v_[i]) / kStep_s : 0;
  return v_[i] + a * std::max(0.0, t_s - k * kStep_s);
}

double Track::aside_m(double t_s) const {
  const double k = std::clamp(t_s / kStep_s, 0.0, static_cast<double>(aside_.size() - 1));
  const auto i = static_cast<std::size_t>(k);
  const double next = aside_[std::min(i + 1, aside_.size() - 1)];
  return aside_[i] + (k - std::floor(k)) * (next - aside_[i]);
}

SE3 Track::pose(double t_s) const {
  const double s = distance_m(t_s);
  // Both axles are on the path.
  const Vector2d front = path_->at(s + wheelbase_m_ / 2);
  const Vector2d rear = path_->at(s - wheelbase_m_ / 2);
  const Vector2d heading = (front - rear).normalized();
  const Vector2d aside = aside_m(t_s) * Vector2d(-heading.y(), heading.x());
  return pose_on_ground((front + rear) / 2 + aside, heading, terrain_);
}

}  // namespace mapless
