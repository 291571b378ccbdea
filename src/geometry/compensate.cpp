#include <array>
#include <cstdlib>
#include <cstring>
#include <span>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include "core/argument_checks.hpp"
#include "geometry/sensor_motion.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/geometry/compensated_scan.hpp>

namespace mapless::inline v1 {

Eigen::Vector3d CompensatedScan::ray_origin_0(int laser, int column) const {
  const LidarModel& model = *scan->model;
  const Eigen::Vector3d& origin_h = model.lasers[static_cast<std::size_t>(laser)].origin_h_m;
  return column_T_0v[static_cast<std::size_t>(column)] * (rotation_z(model.hub_angle(column)) * origin_h);
}

Eigen::Vector3d CompensatedScan::ray_direction_0(int laser, int column) const {
  const LidarModel& model = *scan->model;
  const Eigen::Vector3d direction_h = model.lasers[static_cast<std::size_t>(laser)].direction_h();
  return column_T_0v[static_cast<std::size_t>(column)].rotation() *
         (rotation_z(model.hub_angle(column)) * direction_h);
}

namespace {

void require_measured(const std::shared_ptr<const LidarScan>& scan) {
  require_given("compensate", "scan", scan.get());
  if (scan->compensated_to) {
    throw InputError({"", "scan", "already compensated for motion", "it would be compensated twice",
                      "restore the measured rays first (restore_measured_rays)"});
  }
}

CompensatedScan without_points(std::shared_ptr<const LidarScan> scan, SensorMotion&& motion) {
  CompensatedScan compensated;
  compensated.column_states = std::move(motion.column_states);
  compensated.column_T_0v = std::move(motion.column_T_0v);
  compensated.scan = std::move(scan);
  return compensated;
}

// An affine map of points in single precision, evaluated with four-lane vectors.
class Affine {
 public:
  using Four = float __attribute__((vector_size(16)));
  explicit Affine(const Eigen::Matrix4f& T) { std::memcpy(columns_.data(), T.data(), sizeof(columns_)); }
  [[nodiscard]] Four operator*(const Eigen::Vector3f& p) const {
    return columns_[0] * p.x() + columns_[1] * p.y() + (columns_[2] * p.z() + columns_[3]);
  }

 private:
  std::array<Four, 4> columns_;
};

// Maps p_v at the instant of a column to p_0 - origin_0.
Affine place_of(const SE3& T_0v, const Eigen::Vector3d& origin_0) {
  Eigen::Matrix4f place = Eigen::Matrix4f::Zero();
  place.topLeftCorner<3, 3>() = T_0v.rotation().cast<float>();
  place.topRightCorner<3, 1>() = (T_0v.translation() - origin_0).cast<float>();
  return Affine(place);
}

// Derivative of that map with respect to time [per nanosecond].
Affine drift_of(const SE3& T_0v, const Vector6d& varpi) {
  const Eigen::Matrix3d& C_0v = T_0v.rotation();
  Eigen::Matrix4f drift = Eigen::Matrix4f::Zero();
  drift.topLeftCorner<3, 3>() = (-1e-9 * C_0v * hat(varpi.tail<3>())).cast<float>();
  drift.topRightCorner<3, 1>() = (-1e-9 * C_0v * varpi.head<3>()).cast<float>();
  return Affine(drift);
}

}  // namespace

CompensatedScan compensate(std::shared_ptr<const LidarScan> scan, const Trajectory& trajectory) {
  require_measured(scan);
  SensorMotion motion(*scan, trajectory);
  const std::vector<LidarReturn>& returns = scan->returns;
  std::vector<Eigen::Vector3d> points_0(returns.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, returns.size(), kPointsPerTask),
                    [&](const auto& range) {
                      for (std::size_t i = range.begin(); i < range.end(); ++i) {
                        const LidarReturn& r = returns[i];
                        points_0[i] = motion.to_world(r.position_v.cast<double>(), r.column, r.time_ns);
                      }
                    });
  CompensatedScan compensated = without_points(std::move(scan), std::move(motion));
  compensated.points_0 = std::move(points_0);
  return compensated;
}

std::pair<CompensatedScan, LocalPoints> compensate_locally(std::shared_ptr<const LidarScan> scan,
                                                           const Trajectory& trajectory) {
  require_measured(scan);
  SensorMotion motion(*scan, trajectory);
  LocalPoints local{Eigen::Vector3d::Zero(), std::vector<Eigen::Vector3f>(scan->returns.size())};
  if (!motion.column_T_0v.empty()) local.origin_0 = motion.column_T_0v.front().translation();
  std::vector<Affine> places, drifts;  // drifts are read only where lasers fire at different instants
  places.reserve(motion.column_T_0v.size());
  drifts.reserve(motion.column_T_0v.size());
  for (std::size_t c = 0; c < motion.column_T_0v.size(); ++c) {
    places.push_back(place_of(motion.column_T_0v[c], local.origin_0));
    drifts.push_back(drift_of(motion.column_T_0v[c], motion.column_states[c].varpi));
  }
  const std::int64_t period_ns = scan->column_period.nanoseconds();
  const std::span<const LidarReturn> returns = scan->returns;
  const std::span<Eigen::Vector3f> points = local.points;
  tbb::parallel_for(
      tbb::blocked_range<std::size_t>(0, points.size(), kPointsPerTask),
      [&, returns, points](const auto& range) {
        for (std::size_t i = range.begin(); i < range.end(); ++i) {
          const LidarReturn& r = returns[i];
          const std::int64_t dt_ns = r.time_ns - r.column * period_ns;
          if (std::abs(dt_ns) > period_ns) {  // too long for a first-order motion, see SensorMotion
            const Eigen::Vector3d p_0 = motion.to_world(r.position_v.cast<double>(), r.column, r.time_ns);
            points[i] = (p_0 - local.origin_0).cast<float>();
            continue;
          }
          const auto c = static_cast<std::size_t>(r.column);
          Affine::Four p = places[c] * r.position_v;
          if (dt_ns != 0) p += static_cast<float>(dt_ns) * (drifts[c] * r.position_v);
          points[i] = {p[0], p[1], p[2]};
        }
      });
  return {without_points(std::move(scan), std::move(motion)), std::move(local)};
}

}  // namespace mapless
