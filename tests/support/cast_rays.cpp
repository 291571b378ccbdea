#include "support/cast_rays.hpp"

#include <cmath>
#include <numbers>

#include <mapless/core/errors.hpp>

namespace mapless::test {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

}  // namespace

std::shared_ptr<const LidarModel> awkward_model(int lasers, int columns) {
  auto model = std::make_shared<LidarModel>();
  model->name = "awkward";
  model->columns = columns;
  model->start_azimuth_rad = 170 * kDegree;
  model->min_range_m = 0.5;
  model->max_range_m = 120;
  const double column_ns = 1e8 / columns;
  for (int l = 0; l < lasers; ++l) {
    Laser laser;
    laser.elevation_rad = (-24 + 30.0 * l / lasers) * kDegree;
    laser.azimuth_offset_rad = (-5 + 2.5 * (l % 5)) * kDegree;
    laser.origin_h_m = {0.02 * (l % 3), l % 2 ? 0.026 : -0.026, 0.1 + 0.001 * l};
    laser.firing_offset = Duration::from_nanoseconds(std::llround(column_ns * 0.4 * l / lasers));
    model->lasers.push_back(laser);
  }
  return model;
}

TrajectoryState ScrewTrajectory::at(Time t) const {
  if (t < begin_ || t > end_) throw TrajectoryDomainError({"screw", "time", "", "outside", ""});
  return {SE3::exp((t - begin_).seconds() * varpi_) * T_v0_start_, varpi_};
}

LidarScan cast_rays(std::shared_ptr<const LidarModel> model, Time start, const Trajectory& trajectory,
                    const RangeOfRay& range_of_ray) {
  LidarScan scan;
  scan.start = start;
  scan.columns = model->columns;
  scan.column_period = Duration::from_seconds(1 / model->rotation_rate_hz / model->columns);
  scan.time_source = scan.ring_source = Provenance::sensor;
  scan.input_size = model->lasers.size() * static_cast<std::size_t>(model->columns);
  for (int l = 0; l < static_cast<int>(model->lasers.size()); ++l) {
    const Laser& laser = model->lasers[static_cast<std::size_t>(l)];
    for (int c = 0; c < model->columns; ++c) {
      const Time t = scan.column_time(c) + laser.firing_offset;
      const SE3 T_0h =
          trajectory.at(t).T_v0.inverse() * SE3(rotation_z(model->hub_angle(c)), Eigen::Vector3d::Zero());
      const auto range = range_of_ray(T_0h * laser.origin_h_m, T_0h.rotation() * laser.direction_h());
      const auto input = static_cast<std::uint32_t>(scan.cells.size());
      scan.cells.push_back(range ? static_cast<std::int32_t>(scan.returns.size())
                                 : empty_cell(ReturnCode::nothing));
      if (!range) continue;
      scan.returns.push_back({model->point_v(l, c, *range).cast<float>(), static_cast<float>(*range),
                              static_cast<std::int32_t>((t - start).nanoseconds()), c, l, input});
    }
  }
  scan.model = std::move(model);
  return scan;
}

}  // namespace mapless::test
