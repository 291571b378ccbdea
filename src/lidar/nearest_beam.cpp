#include "lidar/nearest_beam.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>

#include "core/median.hpp"
#include "lidar/recovery/ring_recovery.hpp"

namespace mapless::inline v1 {
namespace {

// A laser as seen by a point of which only height and distance from the spin axis count.
struct Cone {
  double cos_elevation, sin_elevation, forward_m, up_m;

  explicit Cone(const Laser& laser)
      : cos_elevation(std::cos(laser.elevation_rad)),
        sin_elevation(std::sin(laser.elevation_rad)),
        forward_m(laser.origin_h_m.x() * std::cos(laser.azimuth_offset_rad) +
                  laser.origin_h_m.y() * std::sin(laser.azimuth_offset_rad)),
        up_m(laser.origin_h_m.z()) {}

  [[nodiscard]] double distance_m(double rho_m, double z_m) const {
    return std::abs((z_m - up_m) * cos_elevation - (rho_m - forward_m) * sin_elevation);
  }
};

std::vector<Cone> cones_of(const LidarModel& model) {
  std::vector<Cone> cones;
  for (const Laser& laser : model.lasers) cones.emplace_back(laser);
  return cones;
}

// Points that the misfit is the median of: it is then known to a hundredth of itself, and no threshold is
// nearer than that to what a sensor shows.
constexpr std::size_t kPointsForMisfit = 4096;

double median_step_rad(const LidarModel& model) {
  if (model.lasers.size() < 2) return std::numbers::pi;
  std::vector<double> steps;
  for (std::size_t i = 1; i < model.lasers.size(); ++i) {
    steps.push_back(model.lasers[i].elevation_rad - model.lasers[i - 1].elevation_rad);
  }
  return std::max(median(std::move(steps)), 1e-6);
}

}  // namespace

double beam_misfit(const std::vector<Eigen::Vector3f>& points, const std::vector<std::int32_t>& lasers,
                   const LidarModel& model) {
  const std::vector<Cone> cones = cones_of(model);
  std::vector<double> angles;
  angles.reserve(2 * kPointsForMisfit);
  // Odd: firing after firing, a power of two would meet some lasers only.
  const std::size_t stride = (points.size() / kPointsForMisfit) | 1U;
  std::size_t until_next = 0;  // usable points
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!is_usable(points[i])) continue;
    if (until_next > 0) {
      --until_next;
      continue;
    }
    until_next = stride - 1;
    const Eigen::Vector3d p = points[i].cast<double>();
    const Cone& cone = cones[static_cast<std::size_t>(lasers[i])];
    angles.push_back(cone.distance_m(p.head<2>().norm(), p.z()) / p.norm());
  }
  return angles.empty() ? 0 : median(std::move(angles)) / median_step_rad(model);
}

BeamAssignment nearest_beams(const std::vector<Eigen::Vector3f>& points, const LidarModel& model) {
  const std::vector<Cone> cones = cones_of(model);
  BeamAssignment assignment;
  assignment.lasers.assign(points.size(), 0);
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!is_usable(points[i])) continue;
    const double rho_m = points[i].head<2>().cast<double>().norm();
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t laser = 0; laser < cones.size(); ++laser) {
      const double distance = cones[laser].distance_m(rho_m, static_cast<double>(points[i].z()));
      if (distance >= nearest) continue;
      nearest = distance;
      assignment.lasers[i] = static_cast<std::int32_t>(laser);
    }
  }
  assignment.misfit = beam_misfit(points, assignment.lasers, model);
  return assignment;
}

}  // namespace mapless
