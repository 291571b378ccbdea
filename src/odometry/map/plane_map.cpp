#include "odometry/map/plane_map.hpp"

#include <algorithm>
#include <limits>

namespace mapless::inline v1 {
namespace {

// Cubes from the sensor up to which a grid takes points: there a lidar's rays are some 0.5 degrees apart.
constexpr double kFarthestCubes = 80;
// Not on one another's faces: a plane that one grid cuts lies inside the cubes of the next.
constexpr std::array<double, PlaneMap::kGrids> kOffsets = {0.137, 0.371, 0.813, 1.709};
constexpr double kGoodSigmas = 1.5;
// Within so many metres the variance of a plane hardly changes.
constexpr double kHolds = 0.004;

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

void PlaneMap::find_planes(std::span<const Eigen::Vector3d> points_0, std::span<PlaneNear> planes) const {
  struct Search {
    std::size_t point;
    PlaneGrid::Place place;
    PlaneGrid::Candidate best;
    const PlaneGrid* grid = nullptr;  // of the best
  };
  std::vector<Search> open;  // of those that still want a better one
  open.reserve(points_0.size());
  for (std::size_t i = 0; i < points_0.size(); ++i) {
    if (planes[i].holds_at(points_0[i])) continue;
    planes[i] = {std::nullopt, points_0[i], kHolds};
    open.push_back({i, {}, {}});
  }
  for (const PlaneGrid& grid : grids_) {
    for (Search& s : open) {
      const Eigen::Vector3d& p_0 = points_0[s.point];
      s.place = grid.place_of(p_0);
      grid.fetch_slot(s.place);
      planes[s.point].holds_m = std::min(planes[s.point].holds_m, grid.from_face(p_0));
    }
    for (Search& s : open) grid.fetch_plane(s.place);
    std::size_t kept = 0;
    for (std::size_t k = 0; k < open.size(); ++k) {
      Search& s = open[k];
      const PlaneGrid::Candidate candidate = grid.candidate_at(points_0[s.point], s.place);
      if (candidate.variance < s.best.variance) {
        s.best = candidate;
        s.grid = &grid;
      }
      if (s.best.variance > good_variance_ && &grid != &grids_.back()) {
        open[kept++] = s;
      } else if (s.grid != nullptr) {
        planes[s.point].plane = s.grid->plane_of(s.best);
      }
    }
    open.resize(kept);
  }
}

}  // namespace mapless
