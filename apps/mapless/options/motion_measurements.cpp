#include "options/motion_measurements.hpp"

#include <algorithm>
#include <string>

#include <fmt/format.h>

#include "options/option_checks.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/trajectory_file.hpp>

namespace mapless::app {
namespace {

// A lidar on the fastest of vehicles; larger numbers are km/h or mm/s.
constexpr double kMaxSpeed_mps = 200;

void require_some_within(const std::filesystem::path& file, const std::vector<MotionMeasurement>& rows,
                         Time begin, Time end) {
  const auto inside = [&](const MotionMeasurement& one) { return one.time >= begin && one.time < end; };
  if (std::any_of(rows.begin(), rows.end(), inside)) return;
  throw InputError({file.string(), "time_s",
                    fmt::format("{:.3f} to {:.3f}", rows.front().time.seconds(), rows.back().time.seconds()),
                    fmt::format("no row within the scans, which last from {:.3f} to {:.3f} s",
                                begin.seconds(), end.seconds()),
                    "give times on the clock of the scans"});
}

}  // namespace

bool MotionMeasurementOptions::any() const {
  return !initial_velocity_mps.empty() || !speeds.empty() || !angular_velocities.empty();
}

std::vector<MotionMeasurement> MotionMeasurementOptions::measurements(const Dataset& dataset,
                                                                      std::size_t first,
                                                                      std::size_t count) const {
  const Time begin = dataset.scan_start(first), end = dataset.scan_end(first + count - 1);
  std::vector<MotionMeasurement> out = dataset.measurements();
  if (!initial_velocity_mps.empty()) {
    const Eigen::Vector3d value(initial_velocity_mps.data());
    out.push_back({begin, MeasuredMotion::velocity, value, std::nullopt});
  }
  const auto add = [&](const std::filesystem::path& file, auto read) {
    if (file.empty()) return;
    const std::vector<MotionMeasurement> rows = read(file);
    require_some_within(file, rows, begin, end);
    out.insert(out.end(), rows.begin(), rows.end());
  };
  add(speeds, read_speeds);
  add(angular_velocities, read_angular_velocities);
  return out;
}

void add_motion_measurement_options(CLI::App& verb, MotionMeasurementOptions& options) {
  constexpr auto kGroup = "Odometry: measurements of other sensors";
  verb.add_option("--initial-velocity", options.initial_velocity_mps,
                  "velocity of the sensor at the start of the first scan, x,y,z in sensor axes [m/s]; "
                  "standard deviation odometry.velocity_sigma_mps")
      ->delimiter(',')
      ->expected(3)
      ->check(number_between(-kMaxSpeed_mps, kMaxSpeed_mps))
      ->group(kGroup);
  verb.add_option("--speed", options.speeds,
                  "CSV file time_s,speed_m_s: norm of the sensor's velocity, as of wheels; of a vehicle that "
                  "reverses, the absolute value; standard deviation odometry.speed_sigma_mps")
      ->group(kGroup);
  verb.add_option("--imu", options.angular_velocities,
                  "CSV file time_s,x_rad_s,y_rad_s,z_rad_s: angular velocity about the axes of the lidar; "
                  "standard deviation odometry.angular_velocity_sigma_radps")
      ->group(kGroup);
}

}  // namespace mapless::app
