#include "odometry/map/plane_map.hpp"

#include <array>
#include <limits>

#include <tbb/parallel_for.h>

namespace mapless::inline v1 {
namespace {

// Cube sides [m]. Chosen: octaves from the smallest surface that a lidar resolves at 60 m to the largest cube
// that a wall or a road fills.
constexpr std::array<double, PlaneMap::kGrids> kCubes_m = {0.5, 1.0, 2.0, 4.0};
// Largest range at which a grid accepts points, in cube sides. Derived: a cube is 1 / 80 rad = 0.7 deg wide
// there, so that one scan of lasers 0.4 deg or more apart puts at most two lines into it, the fewest of a
// plane, and little of a surface between them. Measured without the limit on the second simulator: four
// HDL-64E drives err by 1 % more over four scans, sixteen VLP-16 drives by 0 to 4 % more or less.
constexpr double kMaxRangeCubes = 80;
// Offset of each grid [m]. Chosen: no two grids share a face, so that a plane cut by one grid lies within the
// cubes of another.
constexpr std::array<double, PlaneMap::kGrids> kOffsets_m = {0.137, 0.371, 0.813, 1.709};
// A plane is good enough to stop looking in coarser grids up to this standard deviation, in expected noises.
// Chosen: the roughness of the surface and the uncertainty of the plane may add as much variance as the noise
// has.
constexpr double kGoodSigmas = 1.5;

}  // namespace

PlaneMap::PlaneMap(double sigma_m, double scale, std::size_t grids) : good_variance_(good_variance(sigma_m)) {
  for (std::size_t g = 0; g < grids; ++g) grids_.emplace_back(lattice(g, scale), sigma_m);
}

CubeLattice PlaneMap::lattice(std::size_t g, double scale) {
  return {scale * kCubes_m[g], scale * kOffsets_m[g]};
}

double PlaneMap::max_range_m(std::size_t g, std::size_t grids) {
  return g + 1 == grids ? std::numeric_limits<double>::infinity() : kMaxRangeCubes * kCubes_m[g];
}

double PlaneMap::good_variance(double sigma_m) { return kGoodSigmas * kGoodSigmas * sigma_m * sigma_m; }

std::vector<unsigned> PlaneMap::insert(std::span<const MapPoint> points) {
  std::array<std::vector<unsigned>, kGrids> accepted;  // by each grid: no grid reads what another one has
  tbb::parallel_for(std::size_t{0}, grids_.size(), [&](std::size_t g) {
    accepted[g].assign(points.size(), 0);
    grids_[g].insert(points, max_range_m(g, grids_.size()), 1U << g, accepted[g]);
  });
  std::vector<unsigned> grids(points.size(), 0);
  for (std::size_t g = 0; g < grids_.size(); ++g) {
    for (std::size_t i = 0; i < grids.size(); ++i) grids[i] |= accepted[g][i];
  }
  return grids;
}

void PlaneMap::remove(const std::vector<InsertedPoint>& points) {
  tbb::parallel_for(std::size_t{0}, grids_.size(), [&](std::size_t g) {
    std::vector<Eigen::Vector3d> of_grid;
    for (const InsertedPoint& point : points) {
      if ((point.grids >> g & 1U) != 0) of_grid.push_back(point.p_0);
    }
    grids_[g].remove(of_grid);
  });
}

void PlaneMap::keep_within(const Eigen::Vector3d& centre_0, double radius_m) {
  tbb::parallel_for(std::size_t{0}, grids_.size(),
                    [&](std::size_t g) { grids_[g].keep_within(centre_0, radius_m); });
}

void PlaneMap::clear() {
  for (PlaneGrid& grid : grids_) grid.clear();
}

std::size_t PlaneMap::cubes() const {
  std::size_t count = 0;
  for (const PlaneGrid& grid : grids_) count += grid.cubes();
  return count;
}

void PlaneMap::find_planes(std::span<const Eigen::Vector3d> points_0, std::span<CachedPlane> planes) const {
  find_planes_in<PlaneGrid>(grids_, good_variance_, points_0, planes);
}

}  // namespace mapless
