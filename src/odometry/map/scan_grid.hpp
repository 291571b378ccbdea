#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "odometry/map/cube_lattice.hpp"
#include "odometry/map/cube_table.hpp"
#include "odometry/map/map_point.hpp"
#include "odometry/map/plane_fit.hpp"

namespace mapless::inline v1 {

/// A grid of cubes like PlaneGrid that keeps the moments of a few scans apart: it has the planes of all scans
/// but any one, each fitted when it is asked for. A cube takes all points.
class ScanGrid {
 public:
  ScanGrid(CubeLattice lattice, double sigma_m) : lattice_(lattice), sigma_m_(sigma_m) {}

  /// Adds the points of the next scan that are at most `max_range_m` from their sensor. Faster if consecutive
  /// points share a cube.
  void add_scan(std::span<const MapPoint> points, double max_range_m);
  /// Keeps the memory.
  void clear();

  /// The planes of all scans but one, as find_planes_in() asks for them.
  class Others {
   public:
    struct Candidate {
      double variance = std::numeric_limits<double>::infinity();
      std::uint64_t key = kNoCube;
      FittedPlane plane;
    };
    /// Every scan counts if there is none of the number `scan`.
    Others(const ScanGrid& grid, std::size_t scan) : grid_(&grid), scan_(scan) {}

    [[nodiscard]] CubePlace place_of(const Eigen::Vector3d& p_0) const {
      return {grid_->lattice_.key_of(p_0)};
    }
    void fetch_slot(const CubePlace& place) const {
      if (place.key != kNoCube) grid_->table_.prefetch(place.key);
    }
    void fetch_cube(CubePlace& place) const {
      if (place.key == kNoCube) return;
      place.cube = grid_->table_.slot_of(place.key).cube;
      if (place.cube >= 0) __builtin_prefetch(&grid_->cubes_[static_cast<std::size_t>(place.cube)]);
    }
    [[nodiscard]] Candidate candidate_at(const Eigen::Vector3d& q_0, const CubePlace& place) const;
    [[nodiscard]] MapPlane plane_of(const Candidate& candidate) const {
      return candidate.plane.in_world(grid_->lattice_.corner_of(candidate.key), candidate.variance);
    }
    [[nodiscard]] double distance_to_face(const Eigen::Vector3d& p_0) const {
      return grid_->lattice_.distance_to_face(p_0);
    }

   private:
    const ScanGrid* grid_;
    std::size_t scan_;
  };

 private:
  // Points of one scan in one cube.
  struct Part {
    std::int32_t cube;
    std::uint64_t lasers = 0;  // bit (laser modulo 64) is set for each laser
    PointSums sums;
  };
  struct Cube {
    std::uint64_t key;
    std::uint64_t lasers = 0;         // of all parts
    std::uint64_t shared_lasers = 0;  // of two parts or more
    int spanned_parts = 0;            // hit by two lasers or more
    PointSums sums;
  };
  // Consecutive points in the same cube.
  struct Run {
    std::uint64_t key;
    std::uint32_t begin;
    std::uint32_t count;
  };

  void add_runs(std::span<const MapPoint> points, std::span<const Run> runs);
  [[nodiscard]] std::int32_t cube_of(std::uint64_t key);
  [[nodiscard]] std::size_t part_of(std::int32_t cube);
  // The part of a scan in a cube; null if it has none.
  [[nodiscard]] const Part* find_part(std::size_t scan, std::size_t cube) const;

  CubeLattice lattice_;
  double sigma_m_;
  CubeTable table_;
  std::vector<Cube> cubes_;
  std::vector<Part> parts_;                          // in the order of their creation, scan by scan
  std::vector<std::vector<std::int32_t>> parts_of_;  // of a scan, by cube; -1: none
  std::size_t scans_ = 0;                            // of parts_of_ that are in use
};

}  // namespace mapless
