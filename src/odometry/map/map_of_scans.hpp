#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "odometry/map/plane_map.hpp"
#include "odometry/map/scan_grid.hpp"

namespace mapless::inline v1 {

/// Planes of a few scans at several scales, as PlaneMap has them, without any one of the scans.
class MapOfScans {
 public:
  /// As PlaneMap.
  explicit MapOfScans(double sigma_m, double scale = 1, std::size_t grids = PlaneMap::kGrids);

  /// Replaces all scans.
  void assign(std::span<const std::vector<MapPoint>> scans);

  /// The map of all scans but one.
  class Others final : public PlaneSource {
   public:
    Others(const MapOfScans& map, std::size_t scan);
    void find_planes(std::span<const Eigen::Vector3d> points_0, std::span<CachedPlane> planes) const override;

   private:
    double good_variance_;
    std::vector<ScanGrid::Others> grids_;
  };
  [[nodiscard]] Others without(std::size_t scan) const { return {*this, scan}; }

 private:
  double good_variance_;
  std::vector<ScanGrid> grids_;
};

}  // namespace mapless
