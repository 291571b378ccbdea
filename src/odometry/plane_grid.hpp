#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "odometry/cube_hash.hpp"

namespace mapless {

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
  double range_m;  ///< from the sensor that saw it
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
  /// each. Not taken are those whose cube is full, or farther than 1e6 cubes from the origin.
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
  };
  [[nodiscard]] Place place_of(const Eigen::Vector3d& p_0) const {
    const double x = in_cubes(p_0.x()), y = in_cubes(p_0.y()), z = in_cubes(p_0.z());
    return {has_cube(x, y, z) ? cube_key(x, y, z) : kNowhere};
  }
  void fetch_slot(const Place& place) const {
    if (place.key != kNowhere) __builtin_prefetch(&table_[cube_slot(place.key, shift_)]);
  }
  void fetch_plane(const Place& place) const;
  /// The plane at a point, as long as the grid stays as it is, and how good it is there (MapPlane::variance);
  /// plane_of is all of it.
  struct Candidate {
    Place place{};
    std::int32_t cube = -1;  ///< none
    double variance = std::numeric_limits<double>::infinity();
  };
  [[nodiscard]] Candidate candidate_at(const Eigen::Vector3d& q_0, const Place& place) const;
  [[nodiscard]] MapPlane plane_of(const Candidate& candidate) const;
  /// How far a point is from the nearest face of its cube [m].
  [[nodiscard]] double from_face(const Eigen::Vector3d& p_0) const;

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
  struct Cube {
    std::uint64_t key;
    std::uint64_t lines = 0;  // bits, the numbers modulo 64
    std::int16_t count = 0;
    std::int16_t fitted = 0;  // count when the plane was fitted
    bool waits = false;       // for its plane to be fitted, in grown_
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    std::array<double, 6> products = {};  // xx, xy, xz, yy, yz, zz
  };
  struct Slot {
    std::uint64_t key = 0;
    std::int32_t cube = -1;  // index into cubes_ and planes_, -1 for empty
    bool full = false;       // the cube, which need not be looked at then
  };

  static constexpr std::uint64_t kNowhere = ~std::uint64_t{0};  // keys have 63 bits

  [[nodiscard]] double in_cubes(double coordinate) const { return (coordinate - offset_m_) * cubes_per_m_; }
  [[nodiscard]] Eigen::Vector3d from_origin(const Eigen::Vector3d& p_0) const;
  [[nodiscard]] Eigen::Vector3d corner_of(std::uint64_t key) const;  // from the origin
  [[nodiscard]] std::int32_t open_cube(const Place& place);
  bool insert(const MapPoint& point, std::size_t i);
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
  void add(Cube& cube, const Eigen::Vector3d& p_0, int sign) const;
  void fit(std::size_t i);
  [[nodiscard]] bool is_cut(const Plane& plane) const;

  double cube_m_, cubes_per_m_, offset_m_, sigma_m_;
  std::vector<Cube> cubes_;    // in the order they came
  std::vector<Plane> planes_;  // of each
  std::vector<std::uint32_t> grown_;
  std::vector<Slot> table_;  // size a power of two
  int shift_ = 0;            // leaves the high bits of the hash
};

}  // namespace mapless
