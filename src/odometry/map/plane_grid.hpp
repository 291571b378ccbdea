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

/// A plane fitted to the points of the map near some query point.
struct MapPlane {
  Eigen::Vector3d point_0;   ///< their mean
  Eigen::Vector3d normal_0;  ///< unit length
  /// Of the distance of a point at the query from the plane [m^2]: how thick the points lie about it, and how
  /// well they know it there.
  double variance;
  double normal_variance;  ///< of the tilt of the normal [rad^2], mean of both directions
};

struct MapPoint {
  Eigen::Vector3d p_0;
  /// Numbers the points of one laser in one scan, which lie on a line on whatever they hit.
  unsigned line;
  double range_m;     ///< from the sensor that saw it
  unsigned pass = 0;  ///< a cube that cannot take all that come takes those of lower passes first
};

/// Sums over the points of each cube of a hash table, and the plane they give. Nothing of a point is kept, so
/// that it costs the same to ask for a plane of ten points or of a hundred. Sums are taken from the corner of
/// the cube, so that precision does not fade far from the origin.
class PlaneGrid {
 public:
  static constexpr int kFewest = 6;       ///< points that give a plane
  static constexpr int kFull = 120;       ///< a cube with that many takes no more
  static constexpr int kFewestLines = 3;  ///< two parallel lines always lie on a plane, whatever they are of

  /// Cubes of `cube_m`, one corner at (offset_m, offset_m, offset_m). `sigma_m`: what is expected of the
  /// noise of a point, believed like six points.
  PlaneGrid(double cube_m, double offset_m, double sigma_m);

  /// Takes the points that are no farther than `farthest_m` from their sensor, and sets `bit` in `taken` of
  /// each. Not taken are those whose cube is full, or farther than 2^20 cubes from the origin. The faster,
  /// the more points of one cube follow one another.
  void insert(const std::vector<MapPoint>& points, double farthest_m, unsigned bit,
              std::vector<unsigned>& taken);
  /// Takes out points that `insert` took, where their cubes are still there.
  void remove(const std::vector<Eigen::Vector3d>& points_0);
  /// Forgets the cubes whose corner is farther from `centre_0`.
  void keep_within(const Eigen::Vector3d& centre_0, double radius_m);
  void clear();

  /// Plane of the points in the cube of `q_0`. None where they are too few, of too few lines, lie on a line
  /// or all about, or where the faces of the cube cut the plane's noise.
  [[nodiscard]] std::optional<MapPlane> plane_at(const Eigen::Vector3d& q_0) const;

  /// The cube of a point. What is kept of a cube lies anywhere in memory: where several points are asked for,
  /// fetch_slot of all of them, then fetch_plane, has it at hand for candidate_at.
  struct Place {
    std::uint64_t key;
    std::int32_t cube = -1;  ///< by fetch_plane; none where it is less than 0
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
  /// The plane at a point, as long as the grid stays as it is, and how good it is there (MapPlane::variance);
  /// plane_of is all of it.
  struct Candidate {
    Place place{};
    double variance = std::numeric_limits<double>::infinity();
  };
  [[nodiscard]] Candidate candidate_at(const Eigen::Vector3d& q_0, const Place& place) const;
  [[nodiscard]] MapPlane plane_of(const Candidate& candidate) const;
  /// How far a point is from the nearest face of its cube [m].
  [[nodiscard]] double from_face(const Eigen::Vector3d& p_0) const {
    const auto off = [&](double p) {
      const double at = in_cubes(p);
      return std::abs(at - nearest_whole(at));
    };
    return cube_m_ * (0.5 - std::max({off(p_0.x()), off(p_0.y()), off(p_0.z())}));
  }

  [[nodiscard]] std::size_t cubes() const { return cubes_.size(); }

 private:
  // Apart from the sums, so that a query touches one line of the cache.
  struct alignas(64) Plane {
    Eigen::Vector3f mean = Eigen::Vector3f::Zero();  // from the corner
    Eigen::Vector3f normal = Eigen::Vector3f::Zero();
    Eigen::Vector3f middle = Eigen::Vector3f::Zero();  // direction of medium extent
    float thickness = 0;                               // variance across the plane
    float uncertainty = 0;                             // variance of the plane at its mean; 0: no plane
    float per_middle = 0, per_largest = 0;  // its growth with the square of the distance from the mean
  };
  // From the corner of a cube.
  struct Sums {
    std::array<double, 3> first = {};
    std::array<double, 6> products = {};  // xx, xy, xz, yy, yz, zz

    void add(double x, double y, double z, int sign);
  };
  struct Cube {
    std::uint64_t key;
    std::uint64_t lines = 0;   // bits, the numbers modulo 64
    std::uint32_t coming = 0;  // points, while `insert` is at work
    std::int16_t count = 0;
    std::int16_t fitted = 0;  // count when the plane was fitted
    bool waits = false;       // for its plane to be fitted, in grown_
    Sums sums;
  };
  struct Slot {
    std::uint64_t key = 0;
    std::int32_t cube = -1;  // index into cubes_ and planes_, -1 for empty
    bool full = false;       // the cube, which need not be looked at then
  };

  // From the middle of the cube at the offset.
  [[nodiscard]] double in_cubes(double coordinate) const { return (coordinate - middle_m_) * cubes_per_m_; }
  [[nodiscard]] Eigen::Vector3d from_origin(const Eigen::Vector3d& p_0) const;
  [[nodiscard]] Eigen::Vector3d corner_of(std::uint64_t key) const;  // from the origin
  // Points of `insert` that follow one another and lie in one cube.
  struct Run {
    std::uint64_t key;
    std::uint32_t begin;
    std::uint32_t count;
    std::int32_t cube = -1;  // none that takes more
  };
  struct Crowded {
    std::uint32_t point;
    std::uint32_t cube;
  };
  [[nodiscard]] std::int32_t open_cube(std::uint64_t key);
  void find_runs(const std::vector<MapPoint>& points, double farthest_m);
  void find_cubes(std::span<Run> runs);
  void take(const std::vector<MapPoint>& points, const Run& run, unsigned bit, std::vector<unsigned>& taken);
  void take_crowded(const std::vector<MapPoint>& points, unsigned bit, std::vector<unsigned>& taken);
  void fit_planes();
  /// Of the cube, or an empty one.
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
  std::vector<Cube> cubes_;    // in the order they came
  std::vector<Plane> planes_;  // of each
  std::vector<std::uint32_t> grown_;
  // Empty but while `insert` is at work: all runs, and the points that their cubes may not have room for.
  std::vector<Run> runs_;
  std::vector<Crowded> crowded_, by_pass_;
  std::vector<Slot> table_;  // size a power of two
  int shift_ = 0;            // leaves the high bits of the hash
};

}  // namespace mapless
