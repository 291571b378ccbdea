#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "odometry/map/cube_hash.hpp"

namespace mapless::inline v1 {

/// A plane fitted to the points of one cube of the map, for one query point.
struct MapPlane {
  Eigen::Vector3d point_0;   ///< mean of the points [m]
  Eigen::Vector3d normal_0;  ///< unit length
  /// Variance of the distance of the query point from the plane [m^2]: the thickness of the points about the
  /// plane, and the uncertainty of the plane at the query point (method.md section 6, "Map").
  double variance;
  double normal_variance;  ///< of the tilt of the normal [rad^2], mean of both directions
};

struct MapPoint {
  Eigen::Vector3d p_0;  ///< [m]
  unsigned laser;
  double range_m;     ///< from the sensor
  unsigned pass = 0;  ///< a cube without room for all points takes those of lower passes first
  unsigned scan = 0;  ///< any number that other scans do not have
};

/// A grid of cubes in a hash table. Each cube keeps the moments of its points and the plane fitted to them,
/// but not the points, so that a query costs the same for ten points or a hundred. Moments are taken from the
/// corner of the cube, so that their precision does not depend on the distance from the origin.
class PlaneGrid {
 public:
  /// Fewest points of a plane. Chosen: twice its degrees of freedom.
  static constexpr int kMinPoints = 6;
  /// A cube accepts no more points than this. Chosen: the standard error of the plane is then below a tenth
  /// of the noise. Measured with 600: of two flying VLP-16 one errs by 0.073 for 0.107 deg per scan, the
  /// other by 0.094 for 0.061 (docs/notebook/odometry.md, "How it starts").
  static constexpr int kMaxPoints = 120;
  /// Fewest lasers of a plane, over all scans. The points of one laser in one scan lie on a line. The lines
  /// of one laser in several scans span a surface whose tilt is decided by the motion estimated between them:
  /// such a plane confirms any motion, also a wrong one. Measured: with three lines
  /// of any laser, 11 of 41 recordings of a VLP-16 are lost; with two lasers, 2 (docs/notebook/odometry.md,
  /// "Planes of one laser").
  static constexpr int kMinLasers = 2;

  /// Cubes with sides of `cube_m`, one corner at (offset_m, offset_m, offset_m). `sigma_m` is the expected
  /// noise of a point; it enters the thickness of a plane with the weight of six points.
  PlaneGrid(double cube_m, double offset_m, double sigma_m);

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

  /// The cube of a point. Cubes lie anywhere in memory: for many queries, call fetch_slot for all of them,
  /// then fetch_plane, then candidate_at, so that the loads overlap.
  struct Place {
    std::uint64_t key;
    std::int32_t cube = -1;  ///< set by fetch_plane; negative if there is no such cube
  };
  [[nodiscard]] Place place_of(const Eigen::Vector3d& p_0) const {
    return {cube_key(in_cubes(p_0.x()), in_cubes(p_0.y()), in_cubes(p_0.z()))};
  }
  void fetch_slot(const Place& place) const {
    if (place.key != kNoCube) __builtin_prefetch(&table_[cube_slot(place.key, shift_)]);
  }
  void fetch_plane(Place& place) const {
    if (place.key == kNoCube) return;
    place.cube = table_[slot_of(place.key)].cube;
    if (place.cube >= 0) __builtin_prefetch(&planes_[static_cast<std::size_t>(place.cube)]);
  }
  /// The variance of the plane at a query point (MapPlane::variance), infinite if there is none. plane_of()
  /// gives the plane itself. Valid until the grid changes.
  struct Candidate {
    Place place{};
    double variance = std::numeric_limits<double>::infinity();
  };
  [[nodiscard]] Candidate candidate_at(const Eigen::Vector3d& q_0, const Place& place) const;
  [[nodiscard]] MapPlane plane_of(const Candidate& candidate) const;
  /// Distance of a point from the nearest face of its cube [m].
  [[nodiscard]] double distance_to_face(const Eigen::Vector3d& p_0) const {
    const auto off = [&](double p) {
      const double at = in_cubes(p);
      return std::abs(at - nearest_integer(at));
    };
    return cube_m_ * (0.5 - std::max({off(p_0.x()), off(p_0.y()), off(p_0.z())}));
  }

  [[nodiscard]] std::size_t cubes() const { return cubes_.size(); }

 private:
  // Apart from the moments, so that a query touches one cache line.
  struct alignas(64) Plane {
    Eigen::Vector3f mean = Eigen::Vector3f::Zero();  // from the corner of the cube
    Eigen::Vector3f normal = Eigen::Vector3f::Zero();
    Eigen::Vector3f middle = Eigen::Vector3f::Zero();  // direction of medium extent
    float thickness = 0;                               // variance across the plane
    float uncertainty = 0;                             // variance of the plane at its mean; 0: no plane
    float per_middle = 0, per_largest = 0;  // its growth with the square of the distance from the mean
  };
  // Moments of the points, from the corner of their cube.
  struct Sums {
    std::array<double, 3> first = {};
    std::array<double, 6> products = {};  // xx, xy, xz, yy, yz, zz

    void add(double x, double y, double z, int sign);
  };
  struct Cube {
    std::uint64_t key;
    std::uint64_t lasers = 0;          // bit (laser modulo 64) is set for each laser
    std::uint64_t lasers_of_scan = 0;  // the same in the scan of the last point
    std::uint32_t scan = 0;            // of the last point
    bool spanned = false;              // two lasers have hit it in one scan
    std::uint32_t pending = 0;         // points that the running insert() has yet to add
    std::int16_t count = 0;
    std::int16_t fitted = 0;     // `count` when the plane was fitted
    bool refit_pending = false;  // the cube is in grown_
    Sums sums;
  };
  struct Slot {
    std::uint64_t key = 0;
    std::int32_t cube = -1;  // index into cubes_ and planes_, -1 for empty
    bool full = false;       // copied from the cube, which need not be read then
  };

  // In cube sides, from the middle of the cube whose corner is the offset.
  [[nodiscard]] double in_cubes(double coordinate) const { return (coordinate - middle_m_) * cubes_per_m_; }
  [[nodiscard]] Eigen::Vector3d from_origin(const Eigen::Vector3d& p_0) const;
  [[nodiscard]] Eigen::Vector3d corner_of(std::uint64_t key) const;  // from the offset
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
  // The slot of the cube, or the empty slot where it belongs.
  [[nodiscard]] std::size_t slot_of(std::uint64_t key) const {
    const std::size_t mask = table_.size() - 1;
    std::size_t slot = cube_slot(key, shift_);
    while (table_[slot].cube >= 0 && table_[slot].key != key) slot = (slot + 1) & mask;
    return slot;
  }
  std::size_t add_cube(std::size_t slot, std::uint64_t key);
  void rebuild_table(std::size_t capacity);
  void fit(std::size_t i);
  [[nodiscard]] bool is_cut(const Plane& plane) const;

  double cube_m_, cubes_per_m_, offset_m_, middle_m_, sigma_m_;
  std::vector<Cube> cubes_;           // in the order of their creation
  std::vector<Plane> planes_;         // one per cube
  std::vector<std::uint32_t> grown_;  // cubes whose plane is due to be fitted again
  // Used within insert() alone.
  std::vector<Run> runs_;
  std::vector<Contested> contested_, contested_by_pass_;
  std::vector<Slot> table_;  // size a power of two
  int shift_ = 0;            // leaves the high bits of the hash
};

}  // namespace mapless
