#pragma once

#include <algorithm>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "odometry/map/cube_table.hpp"
#include "odometry/map/plane_fit.hpp"

namespace mapless::inline v1 {

/// The plane that a map has for a query point.
struct CachedPlane {
  std::optional<MapPlane> plane;
  Eigen::Vector3d query_0 = Eigen::Vector3d::Zero();
  /// Within this distance of query_0 along every axis, the same map has the same plane, of nearly the same
  /// variance. Negative: nothing cached.
  double valid_within_m = -1;

  [[nodiscard]] bool valid_at(const Eigen::Vector3d& p_0) const {
    return (p_0 - query_0).cwiseAbs().maxCoeff() < valid_within_m;
  }
};

/// A map of planes.
class PlaneSource {
 public:
  PlaneSource() = default;
  virtual ~PlaneSource() = default;
  PlaneSource(const PlaneSource&) = default;
  PlaneSource(PlaneSource&&) = default;
  PlaneSource& operator=(const PlaneSource&) = default;
  PlaneSource& operator=(PlaneSource&&) = default;

  /// Finds for every point the finest plane whose variance is not much larger than the noise of a point, else
  /// the plane with the smallest variance. `planes` has one element per point; one that is still valid at its
  /// point is kept.
  virtual void find_planes(std::span<const Eigen::Vector3d> points_0,
                           std::span<CachedPlane> planes) const = 0;
};

/// PlaneSource::find_planes in grids from the finest to the coarsest: PlaneGrid or ScanGrid::Others. A plane
/// whose variance is at most `good_variance` [m^2] is good enough to stop looking in coarser ones.
template <class Grid>
void find_planes_in(std::span<const Grid> grids, double good_variance,
                    std::span<const Eigen::Vector3d> points_0, std::span<CachedPlane> planes) {
  // Reach of a cached plane. Chosen: its variance changes by 2 % at most within it. Measured: drift and
  // errors per scan are the same to 0.1 % in the mean of 44 drives (docs/notebook/odometry.md, "How it
  // starts").
  constexpr double kReuseWithin_m = 0.004;
  struct Search {
    std::size_t point;
    CubePlace place;
    typename Grid::Candidate best;
    const Grid* grid = nullptr;  // of the best
  };
  std::vector<Search> open;  // of points that have no good plane yet
  open.reserve(points_0.size());
  for (std::size_t i = 0; i < points_0.size(); ++i) {
    if (planes[i].valid_at(points_0[i])) continue;
    planes[i] = {std::nullopt, points_0[i], kReuseWithin_m};
    open.push_back({i, {}, {}});
  }
  for (const Grid& grid : grids) {
    for (Search& s : open) {
      const Eigen::Vector3d& p_0 = points_0[s.point];
      s.place = grid.place_of(p_0);
      grid.fetch_slot(s.place);
      planes[s.point].valid_within_m = std::min(planes[s.point].valid_within_m, grid.distance_to_face(p_0));
    }
    for (Search& s : open) grid.fetch_cube(s.place);
    std::size_t kept = 0;
    for (std::size_t k = 0; k < open.size(); ++k) {
      Search& s = open[k];
      const auto candidate = grid.candidate_at(points_0[s.point], s.place);
      if (candidate.variance < s.best.variance) {
        s.best = candidate;
        s.grid = &grid;
      }
      if (s.best.variance > good_variance && &grid != &grids.back()) {
        if (kept != k) open[kept] = s;
        ++kept;
      } else if (s.grid != nullptr) {
        planes[s.point].plane = s.grid->plane_of(s.best);
      }
    }
    open.resize(kept);
  }
}

}  // namespace mapless
