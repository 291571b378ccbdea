#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

#include <CLI/App.hpp>

#include <mapless/io/dataset.hpp>
#include <mapless/trajectory/trajectory.hpp>

namespace mapless::app {

/// What is known of the motion from elsewhere, for the odometry.
struct ToldMotion {
  std::vector<double> initial_velocity_mps;  ///< sensor axes; empty or three numbers
  std::filesystem::path speeds, angular_velocities;

  [[nodiscard]] bool any() const;
  /// All that is told of scans first ... first + count - 1; the initial velocity holds at the start of the
  /// first. Throws InputError for a file that cannot be used or has no row within these scans.
  [[nodiscard]] std::vector<MotionMeasurement> measurements(const Dataset& dataset, std::size_t first,
                                                            std::size_t count) const;
};

/// Adds --initial-velocity, --speed and --imu.
void add_told_motion_options(CLI::App& verb, ToldMotion& told);

}  // namespace mapless::app
