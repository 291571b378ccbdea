#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include <Eigen/Core>

namespace mapless::inline v1 {

/// Exact Euclidean nearest neighbours of a fixed set of points (k-d tree). Points and queries in metres, in
/// one frame; those that are not finite have no neighbours.
class NearestNeighbours {
 public:
  explicit NearestNeighbours(std::vector<Eigen::Vector3d> points);
  ~NearestNeighbours();
  NearestNeighbours(NearestNeighbours&&) noexcept;
  NearestNeighbours& operator=(NearestNeighbours&&) noexcept;

  struct Neighbour {
    std::int32_t index = -1;  ///< in the set given; -1: none
    double distance_m = 0;
  };
  /// The nearest point; of equally near points the one with the lowest index. Index -1 for an empty set.
  [[nodiscard]] Neighbour nearest(const Eigen::Vector3d& q) const;
  /// The same. `hint`: index of a finite point of the set that is probably near q; the nearer it is, the
  /// faster.
  [[nodiscard]] Neighbour nearest(const Eigen::Vector3d& q, Neighbour hint) const;
  /// The k nearest points (fewer if the set is smaller), nearest first. Throws ParameterError for k < 0.
  [[nodiscard]] std::vector<Neighbour> nearest(const Eigen::Vector3d& q, int k) const;
  /// All points within `radius_m` (inclusive), by increasing index; `out` is overwritten. Throws
  /// ParameterError for a negative radius.
  void within(const Eigen::Vector3d& q, double radius_m, std::vector<std::int32_t>& out) const;

 private:
  struct Tree;
  std::unique_ptr<Tree> tree_;
};

}  // namespace mapless
