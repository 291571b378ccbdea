#include "detection/sliding_sides.hpp"

namespace mapless {
namespace {

// A thing is not larger than that many times what was found moving of it.
constexpr std::size_t kMostPerFound = 8;

// Of the ends of rows, how many times as many are in front of something farther as go on into what stands.
constexpr int kFreePerHeld = 3;

}  // namespace

const std::vector<std::int32_t>& SlidingSides::of(std::span<const std::int32_t> thing) {
  sides_.clear();
  const std::size_t most = kMostPerFound * thing.size();
  for (const std::int32_t i : thing) reach(i);
  for (std::size_t next = 0; next < sides_.size() && sides_.size() <= most; ++next) reach(sides_[next]);
  const bool slide = sides_.size() <= most && end_of_themselves();
  for (const std::int32_t i : sides_) reached_[static_cast<std::size_t>(i)] = 0;
  if (!slide) sides_.clear();
  return sides_;
}

void SlidingSides::reach(std::int32_t from) {
  const auto visit = [&](std::int32_t i) {
    const auto n = static_cast<std::size_t>(i);
    if (reached_[n] != 0 || !slides(votes_[n])) return;
    reached_[n] = 1;
    sides_.push_back(i);
  };
  neighbours_.for_each<LinkedNeighbours::Of::unmarked>(from, kSupportRows, kSupportColumns, moving_, visit);
}

// What only the later scan saw may be what the thing has just left free.
bool SlidingSides::slides(const PointVotes& votes) {
  return votes.total() >= kSliding && (votes.earlier != 0 || votes.moving_seen);
}

// Along rows, where neighbours are near to each other at any range: rows may be far apart on the ground.
bool SlidingSides::end_of_themselves() const {
  int free = 0, held = 0;
  for (const std::int32_t i : sides_) {
    for (const int side : {-1, 1}) {
      const std::int32_t j = neighbours_.beside(i, side);
      if (j < 0) continue;
      const auto n = static_cast<std::size_t>(j);
      if (neighbours_.linked(i, j)) {
        held += reached_[n] == 0 && votes_[n].total() < kSliding ? 1 : 0;
      } else {
        free += scan_.returns[n].range_m > scan_.returns[static_cast<std::size_t>(i)].range_m ? 1 : 0;
      }
    }
  }
  return free > kFreePerHeld * held;
}

}  // namespace mapless
