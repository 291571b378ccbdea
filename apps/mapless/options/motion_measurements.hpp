#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

#include <CLI/App.hpp>

#include <mapless/io/dataset.hpp>
#include <mapless/trajectory/trajectory.hpp>

namespace mapless::app {

/// Measurements of the motion by other sensors, for the odometry.
struct MotionMeasurementOptions {
  std::vector<double> initial_velocity_mps;  ///< sensor axes; empty or three numbers
  std::filesystem::path speeds, angular_velocities;

  [[nodiscard]] bool any() const;
  /// The measurements during scans first ... first + count - 1, after those of the recording itself; the
  /// initial velocity holds at the start of the first. Throws InputError for a file that cannot be used or
  /// has no row within these scans.
  [[nodiscard]] std::vector<MotionMeasurement> measurements(const Dataset& dataset, std::size_t first,
                                                            std::size_t count) const;
};

/// Adds --initial-velocity, --speed and --imu.
void add_motion_measurement_options(CLI::App& verb, MotionMeasurementOptions& options);

}  // namespace mapless::app
