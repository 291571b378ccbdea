#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "odometry/map/cube_lattice.hpp"
#include "odometry/map/cube_table.hpp"
#include "odometry/map/map_point.hpp"
#include "odometry/map/plane_fit.hpp"

namespace mapless::inline v1 {

/// A grid of cubes in a hash table. Each cube keeps the moments of its points and the plane fitted to them,
/// but not the points, so that a query costs the same for ten points or a hundred.
class PlaneGrid {
 public:
  /// A cube accepts no more points than this. Chosen: the standard error of the plane is then below a tenth
  /// of the noise. Measured with 600: of two flying VLP-16 one errs by 0.073 for 0.107 deg per scan, the
  /// other by 0.094 for 0.061 (docs/notebook/odometry.md, "How it starts").
  static constexpr int kMaxPoints = 120;

  /// `sigma_m` is the expected noise of a point.
  PlaneGrid(CubeLattice lattice, double sigma_m) : lattice_(lattice), sigma_m_(sigma_m) {}

  /// Adds the points that are at most `max_range_m` from their sensor, and sets `bit` in `grids` of each
  /// point added. A point is not added if its cube is full, or farther than 2^20 cubes from the origin.
  /// Faster if consecutive points share a cube.
  void insert(std::span<const MapPoint> points, double max_range_m, unsigned bit,
              std::vector<unsigned>& grids);
  /// Removes points that `insert` added, if their cubes still exist.
  void remove(const std::vector<Eigen::Vector3d>& points_0);
  /// Removes the cubes whose corner is farther than `radius_m` from `centre_0`.
  void keep_within(const Eigen::Vector3d& centre_0, double radius_m);
  void clear();

  /// The plane of the cube of `q_0`. None if its points are too few, of too few lasers, along one line or
  /// scattered in all directions, or if a face of the cube cuts through the noise of the plane.
  [[nodiscard]] std::optional<MapPlane> plane_at(const Eigen::Vector3d& q_0) const;

  // What find_planes_in() asks for. A candidate is valid until the grid changes.
  [[nodiscard]] CubePlace place_of(const Eigen::Vector3d& p_0) const { return {lattice_.key_of(p_0)}; }
  void fetch_slot(const CubePlace& place) const {
    if (place.key != kNoCube) table_.prefetch(place.key);
  }
  void fetch_cube(CubePlace& place) const {
    if (place.key == kNoCube) return;
    place.cube = table_.slot_of(place.key).cube;
    if (place.cube >= 0) __builtin_prefetch(&planes_[static_cast<std::size_t>(place.cube)]);
  }
  struct Candidate {
    CubePlace place;
    double variance = std::numeric_limits<double>::infinity();  // MapPlane::variance
  };
  [[nodiscard]] Candidate candidate_at(const Eigen::Vector3d& q_0, const CubePlace& place) const;
  [[nodiscard]] MapPlane plane_of(const Candidate& candidate) const;
  [[nodiscard]] double distance_to_face(const Eigen::Vector3d& p_0) const {
    return lattice_.distance_to_face(p_0);
  }

  [[nodiscard]] std::size_t cubes() const { return cubes_.size(); }

 private:
  struct Cube {
    std::uint64_t key;
    std::uint64_t lasers = 0;          // bit (laser modulo 64) is set for each laser
    std::uint64_t lasers_of_scan = 0;  // the same in the scan of the last point
    std::uint32_t scan = 0;            // of the last point
    bool spanned = false;              // two lasers have hit it in one scan
    std::uint32_t pending = 0;         // points that the running insert() has yet to add
    std::int32_t fitted = 0;           // points when the plane was fitted
    bool refit_pending = false;        // the cube is in grown_
    PointSums sums;
  };
  // Consecutive points of insert() in the same cube.
  struct Run {
    std::uint64_t key;
    std::uint32_t begin;
    std::uint32_t count;
    std::int32_t cube = -1;  // negative if it is full
  };
  // A point whose cube may not have room for all points.
  struct Contested {
    std::uint32_t point;
    std::uint32_t cube;
  };
  [[nodiscard]] std::int32_t open_cube(std::uint64_t key);
  void find_runs(std::span<const MapPoint> points, double max_range_m);
  void find_cubes(std::span<Run> runs);
  void add_run(std::span<const MapPoint> points, const Run& run, unsigned bit, std::vector<unsigned>& grids);
  void add_contested(std::span<const MapPoint> points, unsigned bit, std::vector<unsigned>& grids);
  void fit_planes();
  void fit(std::size_t i);

  CubeLattice lattice_;
  double sigma_m_;
  std::vector<Cube> cubes_;           // in the order of their creation
  std::vector<FittedPlane> planes_;   // one per cube, apart from its moments
  std::vector<std::uint32_t> grown_;  // cubes whose plane is due to be fitted again
  // Used within insert() alone.
  std::vector<Run> runs_;
  std::vector<Contested> contested_, contested_by_pass_;
  CubeTable table_;
};

}  // namespace mapless
