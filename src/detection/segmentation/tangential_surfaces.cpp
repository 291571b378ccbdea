#include "detection/segmentation/tangential_surfaces.hpp"

namespace mapless::inline v1 {
namespace {

// Largest ratio of candidates to labelled points of an object. Chosen: it bounds the harm of a wrong
// acceptance.
constexpr std::size_t kMaxPerLabelled = 8;

// Least ratio of free ends to continuations into static points. Measured: commit "Take a side that slides for
// a whole": tilted of seed 201 .742 to .914 (mapless benchmark --scenes tilted --seeds 201).
constexpr int kFreePerStatic = 3;

// The direction of a surface is taken between points this far apart, where range noise turns it by less than
// 10 degrees, and within this many cells.
constexpr float kBaseline_m = 0.2F;
constexpr int kMaxCells = 32;
constexpr float kMinStraight = 0.94F;  // cosine of 20 degrees: the side of a car meets the ground at more

// Least ratio of continuations into moving points at an angle to straight ones, above which the surface is
// the ground: a side has rims and lamps, the ground the angle alone. Measured: commit "Let sides end across
// rows": tilted of seed 803 .536 to .894.
constexpr int kAnglePerStraight = 2;

using Axis = LinkedNeighbours::Axis;

}  // namespace

const std::vector<std::int32_t>& TangentialSurfaces::of(std::span<const std::int32_t> object) {
  surface_.clear();
  const std::size_t most = kMaxPerLabelled * object.size();
  for (const std::int32_t i : object) reach(i);
  for (std::size_t next = 0; next < surface_.size() && surface_.size() <= most; ++next) reach(surface_[next]);
  const bool belongs = surface_.size() <= most && ends_freely();
  for (const std::int32_t i : surface_) reached_[static_cast<std::size_t>(i)] = 0;
  if (!belongs) surface_.clear();
  return surface_;
}

void TangentialSurfaces::reach(std::int32_t from) {
  const auto visit = [&](std::int32_t i) {
    const auto n = static_cast<std::size_t>(i);
    if (reached_[n] != 0 || !is_candidate(votes_[n])) return;
    reached_[n] = 1;
    surface_.push_back(i);
  };
  neighbours_.for_each<LinkedNeighbours::Of::unmarked>(from, kSupportRows, kSupportColumns, moving_, visit);
}

// A point that only the later scan observed may have been uncovered by the object.
bool TangentialSurfaces::is_candidate(const PointEvidence& votes) {
  return votes.total() >= kTangentialVotes && (votes.past != 0 || votes.seen_dynamic);
}

bool TangentialSurfaces::ends_freely() const {
  Rims rims;
  for (const std::int32_t i : surface_) {
    count_along_row(i, rims);
    for (const Axis axis : {Axis::columns, Axis::rows}) {
      for (const int side : {-1, 1}) count_beyond(i, axis, side, rims);
    }
  }
  const int static_points =
      rims.static_points + (rims.at_angle > kAnglePerStraight * rims.straight ? rims.unobserved : 0);
  return rims.free > kFreePerStatic * static_points;
}

// Free ends are counted along rows only, where neighbours are near at any range; on the ground rows are far
// apart.
void TangentialSurfaces::count_along_row(std::int32_t i, Rims& rims) const {
  for (const int side : {-1, 1}) {
    const std::int32_t j = neighbours_.beside(i, Axis::columns, side);
    if (j < 0) continue;
    const auto n = static_cast<std::size_t>(j);
    if (neighbours_.linked(i, j)) {
      rims.static_points += reached_[n] == 0 && votes_[n].total() < kTangentialVotes ? 1 : 0;
    } else {
      rims.free += scan_.returns[n].range_m > scan_.returns[static_cast<std::size_t>(i)].range_m ? 1 : 0;
    }
  }
}

void TangentialSurfaces::count_beyond(std::int32_t i, Axis axis, int side, Rims& rims) const {
  const std::int32_t j = neighbours_.beside(i, axis, side);
  if (j < 0 || reached_[static_cast<std::size_t>(j)] != 0 || !neighbours_.linked(i, j)) return;
  const bool moving = moves(j);
  if (!moving && axis == Axis::columns) return;  // counted along the row
  const bool straight = continues_straight(i, axis, side);
  if (moving) {
    ++(straight ? rims.straight : rims.at_angle);
  } else if (straight) {
    ++(votes_[static_cast<std::size_t>(j)].total() < kTangentialVotes ? rims.static_points : rims.unobserved);
  }
}

bool TangentialSurfaces::moves(std::int32_t i) const {
  const LidarReturn& r = scan_.returns[static_cast<std::size_t>(i)];
  return moving_.window(r.laser, neighbours_.image().aligned_column(r.laser, r.column), 1) != 0;
}

bool TangentialSurfaces::continues_straight(std::int32_t i, Axis axis, int side) const {
  const std::int32_t within = distant(i, axis, -side), beyond = distant(i, axis, side);
  if (within < 0 || beyond < 0 || reached_[static_cast<std::size_t>(within)] == 0) return false;
  const Eigen::Vector3f& p = points_[static_cast<std::size_t>(i)];
  const Eigen::Vector3f within_to_p = p - points_[static_cast<std::size_t>(within)],
                        p_to_beyond = points_[static_cast<std::size_t>(beyond)] - p;
  return within_to_p.dot(p_to_beyond) > kMinStraight * within_to_p.norm() * p_to_beyond.norm();
}

// The first return on that side at least kBaseline_m from return i, or -1.
std::int32_t TangentialSurfaces::distant(std::int32_t i, Axis axis, int side) const {
  const Eigen::Vector3f& p = points_[static_cast<std::size_t>(i)];
  for (int steps = 1; steps <= kMaxCells; ++steps) {
    const std::int32_t j = neighbours_.beside(i, axis, steps * side);
    if (j >= 0 && (points_[static_cast<std::size_t>(j)] - p).squaredNorm() >= kBaseline_m * kBaseline_m)
      return j;
  }
  return -1;
}

}  // namespace mapless
