#include "odometry/start_up.hpp"

#include "odometry/points_in_world.hpp"

namespace mapless {
namespace {

constexpr double kCoarsestScale = 4;  // times the map's cubes and gate

VoxelMap map_of(const std::vector<Eigen::Vector3d>& points_0, double scale) {
  VoxelMap map(scale * VoxelMap::kVoxel, scale * VoxelMap::kSpacing);
  for (const Eigen::Vector3d& p_0 : points_0) map.insert(p_0);
  return map;
}

RegistrationSettings scaled(RegistrationSettings settings, double scale) {
  if (scale > 1) settings.min_direction_share = 0;
  settings.weights.gate_m *= scale;
  settings.weights.robust_scale_m *= scale;
  settings.weights.sigma_m *= scale;
  return settings;
}

}  // namespace

std::optional<Registration> start_up(std::vector<TrajectoryKnot> knots, const KnotPrior& prior,
                                     const LidarScan& first, std::size_t first_interval,
                                     const TimeBins& second, const RegistrationSettings& settings,
                                     const OdometryParameters& parameters) {
  Registration out;
  out.knots = std::move(knots);
  for (double scale = kCoarsestScale; scale >= 1; scale /= 2) {
    const RegistrationSettings level = scaled(settings, scale);
    out.converged = false;
    for (int i = 0; i < settings.max_iterations && !out.converged; ++i) {
      const auto points_0 =
          points_in_world(first, out.knots[first_interval], out.knots[first_interval + 1], parameters);
      if (!improve(prior, second, map_of(points_0, scale), level, out)) return std::nullopt;
    }
  }
  return out;
}

}  // namespace mapless
