#include "detection/tracking/nearest_neighbour_cache.hpp"

#include <algorithm>
#include <cmath>

namespace mapless::inline v1 {
namespace {

using Eigen::Vector3d;

// Rounding of distances on an object, at most: 1e-9 is 1e4 times the resolution of a double at 1 km.
constexpr double kRounding_m = 1e-9;

}  // namespace

void NearestNeighbourCache::reset(std::size_t queries) {
  points_.clear();
  moved_m_ = 0;
  queries_.assign(queries, {});
}

void NearestNeighbourCache::update_points(std::span<const Vector3d> points) {
  double square = 0;
  for (std::size_t i = 0; i < points_.size(); ++i)
    square = std::max(square, (points[i] - points_[i]).squaredNorm());
  moved_m_ += std::sqrt(square);
  points_.assign(points.begin(), points.end());
  is_sorted_ = false;
}

void NearestNeighbourCache::update_query(std::size_t i, const Vector3d& p) {
  if (points_.empty()) return;
  Query& query = queries_[i];
  const double square = (points_[query.neighbour.index] - p).squaredNorm();
  if (still_nearest(query, p, square)) {
    query.neighbour.square = square;
  } else {
    search(p, query);
  }
}

bool NearestNeighbourCache::still_nearest(const Query& query, const Vector3d& p, double square) const {
  if (query.second_m < 0) return false;
  const double moved = (p - query.searched_at).norm() + moved_m_ - query.moved_m;
  return std::sqrt(square) + moved + kRounding_m < query.second_m;
}

void NearestNeighbourCache::search(const Vector3d& p, Query& query) {
  if (!is_sorted_) sorted_.assign(points_);
  is_sorted_ = true;
  const SortedPoints::Nearest found = sorted_.nearest(p);
  query = {{found.index, found.square}, p, moved_m_, std::sqrt(found.second_square)};
}

}  // namespace mapless
