#pragma once

#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include "simulation/traffic/path.hpp"

namespace mapless::inline v1 {

inline constexpr double kTurn = 2 * std::numbers::pi;

[[nodiscard]] inline Eigen::Vector2d polar(double radius, double angle) {
  return {radius * std::cos(angle), radius * std::sin(angle)};
}

/// Round and round a wavy ring about `centre`, `length` long. All in metres and radians.
[[nodiscard]] std::shared_ptr<const Path> wavy_ring(const Eigen::Vector2d& centre, double radius, double wave,
                                                    double phase, double length, bool clockwise);

}  // namespace mapless
