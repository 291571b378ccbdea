#include "detection/segmentation/tangential_surfaces.hpp"

#include <cmath>

namespace mapless::inline v1 {
namespace {

// Largest ratio of candidates to labelled points of an object. Chosen: it bounds the harm of a wrong
// acceptance.
constexpr std::size_t kMaxPerLabelled = 8;

// Least ratio of free ends, or of continuations into the object, to continuations into static points.
// Measured: commit "Take a side that slides for a whole": tilted of seed 201 .742 to .914 (mapless benchmark
// --scenes tilted --seeds 201).
constexpr int kPerStatic = 3;

using Axis = LinkedNeighbours::Axis;

}  // namespace

const std::vector<std::int32_t>& TangentialSurfaces::of(std::span<const std::int32_t> object) {
  surface_.clear();
  const std::size_t most = kMaxPerLabelled * object.size();
  for (const std::int32_t i : object) reach(i);
  for (std::size_t next = 0; next < surface_.size() && surface_.size() <= most; ++next) reach(surface_[next]);
  const bool belongs = surface_.size() <= most && belongs_to_object();
  for (const std::int32_t i : surface_) reached_[static_cast<std::size_t>(i)] = 0;
  if (!belongs) surface_.clear();
  return surface_;
}

void TangentialSurfaces::reach(std::int32_t from) {
  const auto visit = [&](std::int32_t i) {
    const auto n = static_cast<std::size_t>(i);
    if (reached_[n] != 0 || votes_[n].total() < kTangentialVotes) return;
    reached_[n] = 1;
    surface_.push_back(i);
  };
  neighbours_.for_each<LinkedNeighbours::Of::unmarked>(from, kSupportRows, kSupportColumns, moving_, visit);
}

bool TangentialSurfaces::belongs_to_object() const {
  Rim rim;
  for (const std::int32_t i : surface_) {
    for (const Axis axis : {Axis::columns, Axis::rows}) {
      for (const int side : {-1, 1}) count_beside(i, axis, side, rim);
    }
  }
  const double side = std::sqrt(static_cast<double>(surface_.size()));  // of a square of as many points
  return (rim.moving >= side && rim.free > kPerStatic * rim.static_points) ||
         (rim.moving >= 2 * side && rim.moving > kPerStatic * rim.static_points);
}

// Free ends are counted along rows only, where neighbours are near at any range; on the ground rows are far
// apart.
void TangentialSurfaces::count_beside(std::int32_t i, Axis axis, int side, Rim& rim) const {
  const std::int32_t j = neighbours_.beside(i, axis, side);
  if (j < 0 || reached_[static_cast<std::size_t>(j)] != 0) return;
  const auto n = static_cast<std::size_t>(j);
  if (!neighbours_.linked(i, j)) {
    const bool farther = scan_.returns[n].range_m > scan_.returns[static_cast<std::size_t>(i)].range_m;
    rim.free += axis == Axis::columns && farther ? 1 : 0;
  } else if (moves(j)) {
    ++rim.moving;
  } else {
    rim.static_points += votes_[n].total() < kTangentialVotes ? 1 : 0;
  }
}

bool TangentialSurfaces::moves(std::int32_t i) const {
  const LidarReturn& r = scan_.returns[static_cast<std::size_t>(i)];
  return moving_.window(r.laser, neighbours_.image().aligned_column(r.laser, r.column), 1) != 0;
}

}  // namespace mapless
