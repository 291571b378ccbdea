#pragma once

#include <vector>

#include "odometry/solver/window_solver.hpp"
#include <mapless/trajectory/trajectory.hpp>

namespace mapless::inline v1 {

/// By increasing time; each has its sigma.
using MotionMeasurements = std::vector<MotionMeasurement>;

/// Measured minus estimated motion. varpi is minus the velocity and minus the angular velocity of the sensor
/// in its own axes, because it is the velocity of the world as seen from the sensor. Of a speed: the first
/// component, the others are 0.
[[nodiscard]] Eigen::Vector3d measurement_error(const MotionMeasurement& measured, const Vector6d& varpi);

/// Adds the measurements from knot k on and before knot k + 1, each by its instant. Between two knots varpi
/// is taken to change linearly.
void add_measurements(const MotionMeasurements& measurements, const std::vector<TrajectoryKnot>& knots,
                      std::size_t k, WindowSystem& system);

/// Whether `knots` contradict the measurements between their first and last: the mean error of some quantity
/// is more than five standard deviations of one measurement. False without measurements there.
[[nodiscard]] bool contradict(const std::vector<TrajectoryKnot>& knots,
                              const MotionMeasurements& measurements);

}  // namespace mapless
