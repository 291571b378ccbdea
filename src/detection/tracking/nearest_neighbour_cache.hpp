#pragma once

#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "detection/tracking/sorted_points.hpp"

namespace mapless::inline v1 {

/// Of a few hundred points, the nearest to each of as many places, while points and places move a little at a
/// time. The one found last is the nearest still where the others were farther by more than anything moved
/// since; only the others are sought again.
class NearestNeighbourCache {
 public:
  /// Other points and places follow; the memory is kept for them.
  void restart(std::size_t places);
  /// Where the points are now: after restart() as many as one likes, then as many again.
  void move_points(std::span<const Eigen::Vector3d> points);
  /// Place `i` is at `p` now, and the points are where they were moved last.
  void move_place(std::size_t i, const Eigen::Vector3d& p);

  struct Neighbour {
    std::size_t index = 0;
    double square = std::numeric_limits<double>::infinity();
  };
  /// Of those nearest to place `i`, the lowest index; infinitely far without points.
  [[nodiscard]] const Neighbour& of(std::size_t i) const { return places_[i].neighbour; }

 private:
  struct Place {
    Neighbour neighbour;
    Eigen::Vector3d sought_at;
    double moved_m = 0;    // moved_m_ when it was sought
    double others_m = -1;  // how far the others were then; less than 0 before
  };
  [[nodiscard]] bool nearest_still(const Place& place, const Eigen::Vector3d& p, double square) const;
  void seek(const Eigen::Vector3d& p, Place& place);

  std::vector<Eigen::Vector3d> points_;
  double moved_m_ = 0;  // since restart() no point has by more
  SortedPoints sorted_;
  bool is_sorted_ = false;
  std::vector<Place> places_;
};

}  // namespace mapless
