#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "odometry/plane_grid.hpp"

namespace mapless {

/// Planes of the world at several sizes, fine ones where points are dense and surfaces small, coarse ones for
/// sparse points and large surfaces. What is in it depends on the order of insertion alone.
class PlaneMap {
 public:
  static constexpr std::size_t kGrids = 4;
  static constexpr std::array<double, kGrids> kCubes = {0.5, 1.0, 2.0, 4.0};  ///< [m]

  /// `scale` times the cubes, the finest `grids` of them; `sigma_m` is the noise expected of a point.
  explicit PlaneMap(double sigma_m, double scale = 1, std::size_t grids = kGrids);

  /// For each point, bits: the grids that took it. One farther than so many cubes from the sensor is too
  /// sparse there for a fine grid and left to the coarser ones.
  std::vector<unsigned> insert(const std::vector<MapPoint>& points);
  struct TakenPoint {
    Eigen::Vector3d p_0;
    unsigned taken;  ///< by which grids, as insert returned it
  };
  /// Takes out points again.
  void remove(const std::vector<TakenPoint>& points);
  void keep_within(const Eigen::Vector3d& centre_0, double radius_m);
  void clear();

  /// The finest plane at every point that is not much worse than the noise of a point, else the best there
  /// is.
  [[nodiscard]] std::vector<std::optional<MapPlane>> planes_near(
      const std::vector<Eigen::Vector3d>& points_0) const;

  [[nodiscard]] std::size_t cubes() const;

 private:
  double good_variance_;
  std::vector<PlaneGrid> grids_;
};

}  // namespace mapless
