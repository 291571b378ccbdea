#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "odometry/map/plane_grid.hpp"

namespace mapless::inline v1 {

/// What a map that stays as it is has near a point.
struct PlaneNear {
  std::optional<MapPlane> plane;
  Eigen::Vector3d asked_0 = Eigen::Vector3d::Zero();
  double holds_m = -1;  ///< so far about asked_0 the map has no other plane, and hardly another variance

  [[nodiscard]] bool holds_at(const Eigen::Vector3d& p_0) const {
    return (p_0 - asked_0).cwiseAbs().maxCoeff() < holds_m;
  }
};

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
  /// is; one of `planes` for each of the points. Those that hold already stay as they are.
  void find_planes(std::span<const Eigen::Vector3d> points_0, std::span<PlaneNear> planes) const;

  [[nodiscard]] std::size_t cubes() const;

 private:
  double good_variance_;
  std::vector<PlaneGrid> grids_;
};

}  // namespace mapless
