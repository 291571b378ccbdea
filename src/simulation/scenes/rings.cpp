#include "simulation/scenes/rings.hpp"

namespace mapless::inline v1 {

using Eigen::Vector2d;

std::shared_ptr<const Path> wavy_ring(const Vector2d& centre, double radius, double wave, double phase,
                                      double length, bool clockwise) {
  std::vector<Vector2d> points;
  const double step = 2 / radius;
  for (double a = 0; a * radius < length; a += step) {
    const double angle = (clockwise ? -a : a) + phase;
    const double r = radius + wave * std::sin(3 * angle + phase) + 0.5 * wave * std::sin(5 * angle);
    points.push_back(centre + polar(r, angle));
  }
  return std::make_shared<Path>(points);
}

}  // namespace mapless
