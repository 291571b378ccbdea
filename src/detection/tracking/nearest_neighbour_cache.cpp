#include "detection/tracking/nearest_neighbour_cache.hpp"

#include <algorithm>
#include <cmath>

namespace mapless::inline v1 {
namespace {

using Eigen::Vector3d;

constexpr double kRounding_m = 1e-9;  // far more than that of distances on an object

}  // namespace

void NearestNeighbourCache::restart(std::size_t places) {
  points_.clear();
  moved_m_ = 0;
  places_.assign(places, {});
}

void NearestNeighbourCache::move_points(std::span<const Vector3d> points) {
  double square = 0;
  for (std::size_t i = 0; i < points_.size(); ++i)
    square = std::max(square, (points[i] - points_[i]).squaredNorm());
  moved_m_ += std::sqrt(square);
  points_.assign(points.begin(), points.end());
  is_sorted_ = false;
}

void NearestNeighbourCache::move_place(std::size_t i, const Vector3d& p) {
  if (points_.empty()) return;
  Place& place = places_[i];
  const double square = (points_[place.neighbour.index] - p).squaredNorm();
  if (nearest_still(place, p, square)) {
    place.neighbour.square = square;
  } else {
    seek(p, place);
  }
}

bool NearestNeighbourCache::nearest_still(const Place& place, const Vector3d& p, double square) const {
  if (place.others_m < 0) return false;
  const double moved = (p - place.sought_at).norm() + moved_m_ - place.moved_m;
  return std::sqrt(square) + moved + kRounding_m < place.others_m;
}

void NearestNeighbourCache::seek(const Vector3d& p, Place& place) {
  if (!is_sorted_) sorted_.assign(points_);
  is_sorted_ = true;
  const SortedPoints::Nearest found = sorted_.nearest(p);
  place = {{found.index, found.square}, p, moved_m_, std::sqrt(found.others_square)};
}

}  // namespace mapless
