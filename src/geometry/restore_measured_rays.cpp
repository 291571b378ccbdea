#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include "geometry/sensor_motion.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/geometry/compensated_scan.hpp>

namespace mapless::inline v1 {
namespace {

// The (fractional) column, any whole number of turns away, at which `laser` measures p_v.
double column_of(const LidarModel& model, const Laser& laser, const Eigen::Vector3d& p_v) {
  const Eigen::Vector2d beam(std::cos(laser.azimuth_offset_rad), std::sin(laser.azimuth_offset_rad));
  const Eigen::Vector2d origin = laser.origin_h_m.head<2>();
  // In the hub the point is origin + s beam, at the horizontal distance from the axis that p_v has.
  const double b = origin.dot(beam);
  const double s = -b + std::sqrt(std::max(0.0, b * b - origin.squaredNorm() + p_v.head<2>().squaredNorm()));
  const Eigen::Vector2d p_h = origin + s * beam;
  const double hub_angle = std::atan2(p_v.y(), p_v.x()) - std::atan2(p_h.y(), p_h.x());
  return model.sign() * (hub_angle - model.start_azimuth_rad) * model.columns / (2 * std::numbers::pi);
}

// Of the columns that differ from `column` by whole turns, the one within half a turn of `previous`. If that
// lies outside the scan, the one on the other side of the seam.
double unwrapped(double column, double previous, const LidarScan& scan) {
  const double turn = scan.model->columns;
  double c = column + turn * std::round((previous - column) / turn);
  if (c < 0) c += turn;
  if (c >= scan.columns) c -= turn;
  return std::clamp(c, 0.0, static_cast<double>(scan.columns));
}

// Column and instant were recovered from the azimuth of the compensated point, and moving the point changes
// its azimuth: a fixed-point iteration. Each pass multiplies the error by the angular rate of the point's
// direction over that of the hub: by 15/4/63 = 0.06 for 15 m/s past a point at 4 m and 10 Hz (63 rad/s).
void recover_from_azimuth(const LidarScan& scan, const SensorMotion& motion, const Eigen::Vector3d& p_0,
                          LidarReturn& r) {
  constexpr int kPasses = 3;  // 0.06^3 of an initial error of at most half a turn: less than a column
  const Laser& laser = scan.model->lasers[static_cast<std::size_t>(r.laser)];
  double column = r.column;
  for (int pass = 0; pass < kPasses; ++pass) {
    const Eigen::Vector3d p_v = motion.to_sensor(p_0, r.column, r.time_ns);
    column = unwrapped(column_of(*scan.model, laser, p_v), column, scan);
    r.column = std::min(static_cast<int>(std::lround(column)), scan.columns - 1);
    r.time_ns = static_cast<std::int32_t>(
        std::llround(column * static_cast<double>(scan.column_period.nanoseconds())) +
        laser.firing_offset.nanoseconds());
  }
}

// The column of a point whose instant is known: that of its ray, in the turn of the instant. The azimuth of
// the compensated point may be far from it: by 18 degrees at 12 m/s, 4 m beside the sensor.
int measured_column(const LidarScan& scan, const Eigen::Vector3d& p_v, const LidarReturn& r) {
  const Laser& laser = scan.model->lasers[static_cast<std::size_t>(r.laser)];
  const double turn = scan.model->columns;
  const double expected =
      static_cast<double>(r.time_ns) / static_cast<double>(scan.column_period.nanoseconds());
  const double column = column_of(*scan.model, laser, p_v);
  const long nearest = std::lround(column + turn * std::round((expected - column) / turn));
  return static_cast<int>(std::clamp<long>(nearest, 0, scan.columns - 1));
}

void restore(const LidarScan& scan, const SensorMotion& motion, const SE3& T_0c, LidarReturn& r) {
  const Eigen::Vector3d p_0 = T_0c * r.position_v.cast<double>();
  const bool from_angle = scan.time_source == Provenance::recovered_from_angle;
  if (from_angle) recover_from_azimuth(scan, motion, p_0, r);
  const Eigen::Vector3d p_v = motion.to_sensor(p_0, r.column, r.time_ns);
  if (!from_angle) r.column = measured_column(scan, p_v, r);
  const Laser& laser = scan.model->lasers[static_cast<std::size_t>(r.laser)];
  const Eigen::Vector3d origin_v = rotation_z(scan.model->hub_angle(r.column)) * laser.origin_h_m;
  r.position_v = p_v.cast<float>();
  r.range_m = static_cast<float>((p_v - origin_v).norm());
}

// Cells without a return keep their code, unless a return now falls into them.
void lay_out_cells(LidarScan& scan) {
  std::sort(scan.returns.begin(), scan.returns.end(), [](const LidarReturn& a, const LidarReturn& b) {
    return std::tie(a.laser, a.column, a.input_index) < std::tie(b.laser, b.column, b.input_index);
  });
  for (std::int32_t& cell : scan.cells) {
    if (cell >= 0) cell = empty_cell(ReturnCode::absent);
  }
  for (std::size_t i = 0; i < scan.returns.size(); ++i) {
    const LidarReturn& r = scan.returns[i];
    std::int32_t& cell =
        scan.cells[static_cast<std::size_t>(r.laser) * static_cast<std::size_t>(scan.columns) +
                   static_cast<std::size_t>(r.column)];
    if (cell < 0 || r.range_m < scan.returns[static_cast<std::size_t>(cell)].range_m) {
      cell = static_cast<std::int32_t>(i);
    }
  }
}

}  // namespace

LidarScan restore_measured_rays(const LidarScan& scan, const Trajectory& trajectory) {
  if (!scan.compensated_to) {
    throw InputError({"", "scan", "not compensated for motion", "there is no compensation to undo",
                      "compensate it as it is"});
  }
  const SE3 T_0c = trajectory.at(*scan.compensated_to).T_v0.inverse();
  const SensorMotion motion(scan, trajectory);
  LidarScan restored = scan;
  restored.compensated_to.reset();
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, restored.returns.size(), kPointsPerTask),
                    [&](const auto& range) {
                      for (std::size_t i = range.begin(); i < range.end(); ++i)
                        restore(scan, motion, T_0c, restored.returns[i]);
                    });
  lay_out_cells(restored);
  return restored;
}

}  // namespace mapless
