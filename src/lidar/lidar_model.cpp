#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <mapless/core/errors.hpp>
#include <mapless/lidar/lidar_model.hpp>

namespace mapless::inline v1 {
namespace {

[[noreturn]] void refuse(const std::string& source, const std::string& field, const std::string& value,
                         const std::string& problem) {
  throw InputError({source, field, value, problem, "correct the description of the sensor"});
}

// No spinning lidar is beyond these bounds: a value that is was given in another unit (degrees, millimetres,
// nanoseconds). An image within them fits memory, a range within them single precision.
constexpr int kMostColumns = 1'000'000;
// Sensors on sale turn 5 to 20 times a second, with a mirror for one line up to 200 times. Turns a minute are
// 300 and more, of times in microseconds that are called nanoseconds 5,000, in milliseconds that are called
// seconds .02 and less.
constexpr double kFastest_hz = 250, kSlowest_hz = 0.1;
constexpr double kFarthest_m = 1e6;
constexpr double kFarthestOrigin_m = 10;  // of a laser from the origin of the hub
// Two turns: a scan may begin a turn after the start of its model.
constexpr double kLargestAngle_rad = 4 * std::numbers::pi;
// 400 MB of cells: eight times the largest scan of a named model.
constexpr double kMostCells = 1e8;

void require_angle(double angle_rad, const std::string& field, const std::string& source) {
  if (std::abs(angle_rad) <= kLargestAngle_rad) return;  // false for NaN
  refuse(source, field, fmt::format("{:g} degrees", angle_rad * 180 / std::numbers::pi),
         "not from -720 to 720 degrees");
}

void require_positive(double value, const std::string& field, const std::string& source) {
  if (!(std::isfinite(value) && value > 0))
    refuse(source, field, fmt::format("{}", value), "not a positive number");
}

void validate_laser(const Laser& laser, std::size_t index, double turn_s, const std::string& source) {
  const std::string name = fmt::format("laser {}", index);
  const auto require_finite = [&](double value, const char* field) {
    if (!std::isfinite(value)) refuse(source, name + " " + field, fmt::format("{}", value), "not finite");
  };
  require_finite(laser.elevation_rad, "elevation");
  require_angle(laser.azimuth_offset_rad, name + " azimuth offset", source);
  for (const double coordinate : laser.origin_h_m) {
    require_finite(coordinate, "origin");
    if (std::abs(coordinate) > kFarthestOrigin_m)
      refuse(source, name + " origin", fmt::format("{} m", coordinate),
             fmt::format("more than {} m from the origin of the hub", kFarthestOrigin_m));
  }
  if (std::abs(laser.elevation_rad) >= std::numbers::pi / 2) {
    refuse(source, name + " elevation", fmt::format("{} rad", laser.elevation_rad),
           "not between straight down and straight up");
  }
  if (std::abs(laser.firing_offset.seconds()) > turn_s) {
    refuse(source, name + " firing offset", fmt::format("{} s", laser.firing_offset.seconds()),
           fmt::format("longer than a turn of {} s", turn_s));
  }
}

}  // namespace

Eigen::Vector3d Laser::direction_h() const {
  const double c = std::cos(elevation_rad);
  return {c * std::cos(azimuth_offset_rad), c * std::sin(azimuth_offset_rad), std::sin(elevation_rad)};
}

SE3 Laser::T_lh() const {
  const Eigen::Vector3d x = direction_h();
  // The cross product of the hub's z with x, normalised; written out, so that it is a unit vector for a beam
  // along the spin axis too.
  const Eigen::Vector3d y(-std::sin(azimuth_offset_rad), std::cos(azimuth_offset_rad), 0);
  Eigen::Matrix3d C_lh;
  C_lh << x.transpose(), y.transpose(), x.cross(y).transpose();
  return {C_lh, -(C_lh * origin_h_m)};
}

double LidarModel::hub_angle(double column) const {
  return start_azimuth_rad + sign() * 2 * std::numbers::pi * column / columns;
}

Eigen::Vector3d LidarModel::point_v(int laser, double column, double range_m) const {
  const Laser& l = lasers[static_cast<std::size_t>(laser)];
  return rotation_z(hub_angle(column)) * (l.origin_h_m + range_m * l.direction_h());
}

double LidarModel::elevation_step(int laser) const {
  const auto l = static_cast<std::size_t>(laser);
  double step = 0;
  if (l > 0) step = lasers[l].elevation_rad - lasers[l - 1].elevation_rad;
  if (l + 1 < lasers.size()) step = std::max(step, lasers[l + 1].elevation_rad - lasers[l].elevation_rad);
  return step;
}

double LidarModel::largest_elevation_step() const {
  double step = 0;
  for (std::size_t i = 1; i < lasers.size(); ++i) {
    step = std::max(step, lasers[i].elevation_rad - lasers[i - 1].elevation_rad);
  }
  return step;
}

double LidarModel::mean_elevation_step() const {
  if (lasers.size() < 2) return 0;
  const double span_rad = lasers.back().elevation_rad - lasers.front().elevation_rad;
  return span_rad / static_cast<double>(lasers.size() - 1);
}

void validate(const LidarModel& model, const std::string& source) {
  if (model.lasers.empty()) refuse(source, "lasers", "", "none given");
  if (model.columns <= 0) refuse(source, "columns", std::to_string(model.columns), "not a positive number");
  if (model.columns > kMostColumns)
    refuse(source, "columns", std::to_string(model.columns), fmt::format("more than {}", kMostColumns));
  if (static_cast<double>(model.columns) * static_cast<double>(model.lasers.size()) > kMostCells)
    refuse(source, "columns x lasers", fmt::format("{} x {}", model.columns, model.lasers.size()),
           fmt::format("more than {:g}", kMostCells));
  require_positive(model.rotation_rate_hz, "rate_hz", source);
  if (model.rotation_rate_hz < kSlowest_hz || model.rotation_rate_hz > kFastest_hz)
    refuse(source, "rate_hz", fmt::format("{}", model.rotation_rate_hz),
           fmt::format("not from {} to {}: turns a minute, or times in another unit?", kSlowest_hz,
                       kFastest_hz));
  require_positive(model.max_range_m, "max_range_m", source);
  if (model.max_range_m > kFarthest_m)
    refuse(source, "max_range_m", fmt::format("{}", model.max_range_m),
           fmt::format("more than {}", kFarthest_m));
  if (!(model.min_range_m >= 0 && model.min_range_m < model.max_range_m)) {
    refuse(source, "min_range_m", fmt::format("{}", model.min_range_m),
           fmt::format("not between 0 and max_range_m = {}", model.max_range_m));
  }
  require_angle(model.start_azimuth_rad, "start_azimuth", source);
  for (std::size_t i = 0; i < model.lasers.size(); ++i) {
    validate_laser(model.lasers[i], i, 1 / model.rotation_rate_hz, source);
    if (i > 0 && model.lasers[i].elevation_rad < model.lasers[i - 1].elevation_rad) {
      refuse(source, fmt::format("laser {} elevation", i),
             fmt::format("{} rad", model.lasers[i].elevation_rad),
             fmt::format("below the laser before it ({} rad): lasers are sorted by increasing elevation",
                         model.lasers[i - 1].elevation_rad));
    }
  }
}

}  // namespace mapless
