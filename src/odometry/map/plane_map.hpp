#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "odometry/map/plane_grid.hpp"
#include "odometry/map/plane_search.hpp"

namespace mapless::inline v1 {

// map/ is the rolling map of planes. Points of registered scans, in the world frame, go in; the plane nearest
// to a query point, with its variance, comes out. The result depends on the order of insertion alone. Only
// MappedTrajectory inserts and removes points.

/// Planes at several scales: fine ones for dense points and small surfaces, coarse ones for sparse points and
/// large surfaces (method.md section 6, "Map").
class PlaneMap final : public PlaneSource {
 public:
  static constexpr std::size_t kGrids = 4;

  /// The finest `grids` grids, their cubes `scale` times as large. `sigma_m` is the expected noise of a
  /// point.
  explicit PlaneMap(double sigma_m, double scale = 1, std::size_t grids = kGrids);

  /// The cubes of grid g `scale` times as large.
  [[nodiscard]] static CubeLattice lattice(std::size_t g, double scale);
  /// Largest range of the points of grid g of `grids` [m].
  [[nodiscard]] static double max_range_m(std::size_t g, std::size_t grids);
  /// A plane that certain is good enough to stop looking in coarser grids [m^2].
  [[nodiscard]] static double good_variance(double sigma_m);

  /// Returns for each point the grids that accepted it, bit g for grid g. A fine grid does not accept points
  /// from far away, where they are too sparse for its cubes.
  std::vector<unsigned> insert(std::span<const MapPoint> points);
  struct InsertedPoint {
    Eigen::Vector3d p_0;
    unsigned grids;  ///< as insert() returned them
  };
  /// Removes points that insert() accepted.
  void remove(const std::vector<InsertedPoint>& points);
  void keep_within(const Eigen::Vector3d& centre_0, double radius_m);
  void clear();

  void find_planes(std::span<const Eigen::Vector3d> points_0, std::span<CachedPlane> planes) const override;

  [[nodiscard]] std::size_t cubes() const;

 private:
  double good_variance_;
  std::vector<PlaneGrid> grids_;
};

}  // namespace mapless
