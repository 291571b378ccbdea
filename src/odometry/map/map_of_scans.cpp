#include "odometry/map/map_of_scans.hpp"

#include <tbb/parallel_for.h>

namespace mapless::inline v1 {

MapOfScans::MapOfScans(double sigma_m, double scale, std::size_t grids)
    : good_variance_(PlaneMap::good_variance(sigma_m)) {
  for (std::size_t g = 0; g < grids; ++g) grids_.emplace_back(PlaneMap::lattice(g, scale), sigma_m);
}

void MapOfScans::assign(std::span<const std::vector<MapPoint>> scans) {
  tbb::parallel_for(std::size_t{0}, grids_.size(), [&](std::size_t g) {
    grids_[g].clear();
    const double max_range_m = PlaneMap::max_range_m(g, grids_.size());
    for (const std::vector<MapPoint>& points : scans) grids_[g].add_scan(points, max_range_m);
  });
}

MapOfScans::Others::Others(const MapOfScans& map, std::size_t scan) : good_variance_(map.good_variance_) {
  for (const ScanGrid& grid : map.grids_) grids_.emplace_back(grid, scan);
}

void MapOfScans::Others::find_planes(std::span<const Eigen::Vector3d> points_0,
                                     std::span<CachedPlane> planes) const {
  find_planes_in<ScanGrid::Others>(grids_, good_variance_, points_0, planes);
}

}  // namespace mapless
