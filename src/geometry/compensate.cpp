
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include "geometry/sensor_motion.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/geometry/compensated_scan.hpp>

namespace mapless {

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

CompensatedScan compensate(std::shared_ptr<const LidarScan> scan, const Trajectory& trajectory) {
  if (scan->compensated_to) {
    throw InputError({"", "scan", "already compensated for motion", "would be compensated twice",
                      "take it back to the measured rays first (restore_measured_rays)"});
  }
  SensorMotion motion(*scan, trajectory);
  CompensatedScan compensated;
  const std::vector<LidarReturn>& returns = scan->returns;
  compensated.points_0.resize(returns.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, returns.size(), 1024), [&](const auto& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) {
      const LidarReturn& r = returns[i];
      compensated.points_0[i] = motion.to_world(r.position_v.cast<double>(), r.column, r.time_ns);
    }
  });
  compensated.column_states = std::move(motion.column_states);
  compensated.column_T_0v = std::move(motion.column_T_0v);
  compensated.scan = std::move(scan);
  return compensated;
}

}  // namespace mapless
