#pragma once

#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include "simulation/traffic/path.hpp"

namespace mapless::inline v1 {

/// One turn [rad].
inline constexpr double kTurn = 2 * std::numbers::pi;

/// The point (x, y) at this radius [m] and angle [rad].
[[nodiscard]] inline Eigen::Vector2d polar(double radius, double angle) {
  return {radius * std::cos(angle), radius * std::sin(angle)};
}

/// A path of `length` along a wavy ring about `centre`, lap after lap. Lengths in metres, phase in radians.
[[nodiscard]] std::shared_ptr<const Path> wavy_ring(const Eigen::Vector2d& centre, double radius, double wave,
                                                    double phase, double length, bool clockwise);

}  // namespace mapless
