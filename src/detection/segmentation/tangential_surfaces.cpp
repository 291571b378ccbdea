#include "detection/segmentation/tangential_surfaces.hpp"

namespace mapless::inline v1 {
namespace {

// A thing is not larger than that many times what was found moving of it.
constexpr std::size_t kMostPerFound = 8;

// Of their ends, how many times as many are in front of something farther as go on into what stands.
constexpr int kFreePerHeld = 3;

// How straight a surface goes on is told by points so far apart, no more than so many cells: by less the
// noise decides.
constexpr float kApart_m = 0.2F;
constexpr int kMostCells = 32;
constexpr float kStraightOn = 0.94F;  // cosine of 20 degrees: a side does not go on into the ground so

// Where what moves goes on, so many times as often at an angle as straight: a side has rims and lights, and
// the ground beneath it has the angle alone.
constexpr int kBentPerStraight = 2;

using Way = LinkedNeighbours::Way;

}  // namespace

const std::vector<std::int32_t>& TangentialSurfaces::of(std::span<const std::int32_t> thing) {
  sides_.clear();
  const std::size_t most = kMostPerFound * thing.size();
  for (const std::int32_t i : thing) reach(i);
  for (std::size_t next = 0; next < sides_.size() && sides_.size() <= most; ++next) reach(sides_[next]);
  const bool slide = sides_.size() <= most && end_of_themselves();
  for (const std::int32_t i : sides_) reached_[static_cast<std::size_t>(i)] = 0;
  if (!slide) sides_.clear();
  return sides_;
}

void TangentialSurfaces::reach(std::int32_t from) {
  const auto visit = [&](std::int32_t i) {
    const auto n = static_cast<std::size_t>(i);
    if (reached_[n] != 0 || !slides(votes_[n])) return;
    reached_[n] = 1;
    sides_.push_back(i);
  };
  neighbours_.for_each<LinkedNeighbours::Of::unmarked>(from, kSupportRows, kSupportColumns, moving_, visit);
}

// What only the later scan saw may be what the thing has just left free.
bool TangentialSurfaces::slides(const PointVotes& votes) {
  return votes.total() >= kSliding && (votes.earlier != 0 || votes.moving_seen);
}

bool TangentialSurfaces::end_of_themselves() const {
  Rims rims;
  for (const std::int32_t i : sides_) {
    look_along(i, rims);
    for (const Way way : {Way::columns, Way::rows}) {
      for (const int side : {-1, 1}) look_beyond(i, way, side, rims);
    }
  }
  const int held = rims.held + (rims.bent > kBentPerStraight * rims.straight ? rims.unknown : 0);
  return rims.free > kFreePerHeld * held;
}

// Along rows, where neighbours are near to each other at any range: rows may be far apart on the ground.
void TangentialSurfaces::look_along(std::int32_t i, Rims& rims) const {
  for (const int side : {-1, 1}) {
    const std::int32_t j = neighbours_.beside(i, Way::columns, side);
    if (j < 0) continue;
    const auto n = static_cast<std::size_t>(j);
    if (neighbours_.linked(i, j)) {
      rims.held += reached_[n] == 0 && votes_[n].total() < kSliding ? 1 : 0;
    } else {
      rims.free += scan_.returns[n].range_m > scan_.returns[static_cast<std::size_t>(i)].range_m ? 1 : 0;
    }
  }
}

void TangentialSurfaces::look_beyond(std::int32_t i, Way way, int side, Rims& rims) const {
  const std::int32_t j = neighbours_.beside(i, way, side);
  if (j < 0 || reached_[static_cast<std::size_t>(j)] != 0 || !neighbours_.linked(i, j)) return;
  const bool moving = moves(j);
  if (!moving && way == Way::columns) return;  // look_along has told
  const bool straight = goes_straight_on(i, way, side);
  if (moving) {
    ++(straight ? rims.straight : rims.bent);
  } else if (straight) {
    ++(votes_[static_cast<std::size_t>(j)].total() < kSliding ? rims.held : rims.unknown);
  }
}

bool TangentialSurfaces::moves(std::int32_t i) const {
  const LidarReturn& r = scan_.returns[static_cast<std::size_t>(i)];
  return moving_.window(r.laser, neighbours_.image().aligned_column(r.laser, r.column), 1) != 0;
}

bool TangentialSurfaces::goes_straight_on(std::int32_t i, Way way, int side) const {
  const std::int32_t within = apart(i, way, -side), beyond = apart(i, way, side);
  if (within < 0 || beyond < 0 || reached_[static_cast<std::size_t>(within)] == 0) return false;
  const Eigen::Vector3f& p = points_[static_cast<std::size_t>(i)];
  const Eigen::Vector3f to = p - points_[static_cast<std::size_t>(within)],
                        on = points_[static_cast<std::size_t>(beyond)] - p;
  return to.dot(on) > kStraightOn * to.norm() * on.norm();
}

// The first return that way that is far enough off, or -1.
std::int32_t TangentialSurfaces::apart(std::int32_t i, Way way, int side) const {
  const Eigen::Vector3f& p = points_[static_cast<std::size_t>(i)];
  for (int steps = 1; steps <= kMostCells; ++steps) {
    const std::int32_t j = neighbours_.beside(i, way, steps * side);
    if (j >= 0 && (points_[static_cast<std::size_t>(j)] - p).squaredNorm() >= kApart_m * kApart_m) return j;
  }
  return -1;
}

}  // namespace mapless
