#include "odometry/plane_map.hpp"

#include <limits>
#include <numeric>

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

std::vector<unsigned> PlaneMap::insert(const std::vector<MapPoint>& points) {
  std::vector<unsigned> taken(points.size(), 0);
  for (std::size_t g = 0; g < grids_.size(); ++g) {
    const double farthest_m =
        g + 1 == grids_.size() ? std::numeric_limits<double>::infinity() : kFarthestCubes * kCubes[g];
    grids_[g].insert(points, farthest_m, 1U << g, taken);
  }
  return taken;
}

void PlaneMap::remove(const std::vector<TakenPoint>& points) {
  std::vector<Eigen::Vector3d> of_grid;
  for (std::size_t g = 0; g < grids_.size(); ++g) {
    of_grid.clear();
    for (const TakenPoint& point : points) {
      if ((point.taken >> g & 1U) != 0) of_grid.push_back(point.p_0);
    }
    grids_[g].remove(of_grid);
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

std::vector<std::optional<MapPlane>> PlaneMap::planes_near(
    const std::vector<Eigen::Vector3d>& points_0) const {
  struct Best {
    PlaneGrid::Candidate candidate;
    const PlaneGrid* grid = nullptr;
  };
  std::vector<Best> best(points_0.size());
  std::vector<PlaneGrid::Place> places(points_0.size());
  std::vector<std::size_t> open(points_0.size());  // those that still want a better one
  std::iota(open.begin(), open.end(), std::size_t{0});
  for (const PlaneGrid& grid : grids_) {
    for (const std::size_t i : open) {
      places[i] = grid.place_of(points_0[i]);
      grid.fetch_slot(places[i]);
    }
    for (const std::size_t i : open) grid.fetch_plane(places[i]);
    std::erase_if(open, [&](std::size_t i) {
      const PlaneGrid::Candidate candidate = grid.candidate_at(points_0[i], places[i]);
      if (candidate.variance < best[i].candidate.variance) best[i] = {candidate, &grid};
      return best[i].candidate.variance <= good_variance_;
    });
  }
  std::vector<std::optional<MapPlane>> planes(points_0.size());
  for (std::size_t i = 0; i < planes.size(); ++i) {
    if (best[i].grid != nullptr) planes[i] = best[i].grid->plane_of(best[i].candidate);
  }
  return planes;
}

}  // namespace mapless
