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

SE3 carried(const Track& track, double height_m, double t_s) {
  const double steps = kTurn * track.distance_m(t_s) / 0.7;
  const SE3 sway(
      so3_exp({0.04 * std::sin(steps / 2), 0.03 * std::sin(steps), 0.06 * std::sin(steps / 2 + 0.7)}),
      {0, 0.03 * std::sin(steps / 2), height_m + 0.03 * std::sin(steps)});
  return track.pose(t_s) * sway;
}

}  // namespace mapless
