#pragma once

#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "detection/tracking/sorted_points.hpp"

namespace mapless::inline v1 {

/// Nearest of a few hundred points to each of as many queries, while both move a little at a time. The last
/// answer of a query is still right as long as all other points were farther, when it was searched, than
/// everything has moved since; only the other queries are searched again.
class NearestNeighbourCache {
 public:
  /// Forgets all points and answers; the memory is kept.
  void reset(std::size_t queries);
  /// Sets the points: after reset() any number of them, then always as many.
  void update_points(std::span<const Eigen::Vector3d> points);
  /// Moves query `i` to `p` and finds its nearest point.
  void update_query(std::size_t i, const Eigen::Vector3d& p);

  struct Neighbour {
    std::size_t index = 0;  ///< the lowest of equally near points
    double square =
        std::numeric_limits<double>::infinity();  ///< of the distance [m^2]; infinite without points
  };
  /// The point nearest to query `i`.
  [[nodiscard]] const Neighbour& nearest(std::size_t i) const { return queries_[i].neighbour; }

 private:
  struct Query {
    Neighbour neighbour;
    Eigen::Vector3d searched_at;
    double moved_m = 0;    // moved_m_ when it was searched
    double second_m = -1;  // distance of the second nearest then; below 0 before the first search
  };
  [[nodiscard]] bool still_nearest(const Query& query, const Eigen::Vector3d& p, double square) const;
  void search(const Eigen::Vector3d& p, Query& query);

  std::vector<Eigen::Vector3d> points_;
  double moved_m_ = 0;  // bound on how far any point has moved since reset()
  SortedPoints sorted_;
  bool is_sorted_ = false;
  std::vector<Query> queries_;
};

}  // namespace mapless
