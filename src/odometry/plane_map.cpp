#include "odometry/plane_map.hpp"

namespace mapless {
namespace {

// Cubes from the sensor up to which a grid takes points: there a lidar's rays are some 0.5 degrees apart.
constexpr double kFarthestCubes = 80;
// Not on one another's faces: a plane that one grid cuts lies inside the cubes of the next.
constexpr std::array<double, PlaneMap::kGrids> kOffsets = {0.137, 0.371, 0.813, 1.709};
constexpr double kGoodSigmas = 1.5;

}  // namespace

PlaneMap::PlaneMap(double sigma_m, double scale, std::size_t grids)
    : good_variance_(kGoodSigmas * kGoodSigmas * sigma_m * sigma_m) {
  for (std::size_t g = 0; g < grids; ++g)
    grids_.emplace_back(scale * kCubes[g], scale * kOffsets[g], sigma_m);
}

unsigned PlaneMap::insert(const Eigen::Vector3d& p_0, unsigned line, double range_m) {
  unsigned taken = 0;
  for (std::size_t g = 0; g < grids_.size(); ++g) {
    if (g + 1 < grids_.size() && range_m > kFarthestCubes * kCubes[g]) continue;
    if (grids_[g].insert(p_0, line)) taken |= 1U << g;
  }
  return taken;
}

void PlaneMap::remove(const Eigen::Vector3d& p_0, unsigned taken) {
  for (std::size_t g = 0; g < grids_.size(); ++g) {
    if ((taken >> g & 1U) != 0) grids_[g].remove(p_0);
  }
}

void PlaneMap::keep_within(const Eigen::Vector3d& centre_0, double radius_m) {
  for (PlaneGrid& grid : grids_) grid.keep_within(centre_0, radius_m);
}

void PlaneMap::clear() {
  for (PlaneGrid& grid : grids_) grid.clear();
}

std::size_t PlaneMap::cubes() const {
  std::size_t count = 0;
  for (const PlaneGrid& grid : grids_) count += grid.cubes();
  return count;
}

std::optional<MapPlane> PlaneMap::plane_near(const Eigen::Vector3d& q_0) const {
  std::optional<MapPlane> best;
  for (const PlaneGrid& grid : grids_) {
    const auto plane = grid.plane_at(q_0);
    if (plane && (!best || plane->variance < best->variance)) best = plane;
    if (best && best->variance <= good_variance_) break;
  }
  return best;
}

}  // namespace mapless
