#include "odometry/map/cube_table.hpp"

#include <algorithm>
#include <bit>

namespace mapless::inline v1 {
namespace {

// Slots of an empty table; it doubles when half full. Chosen: 64 kB; affects speed alone.
constexpr std::size_t kInitialSlots = 4096;

}  // namespace

void CubeTable::clear() {
  slots_.assign(std::max(slots_.size(), kInitialSlots), {});
  shift_ = 64 - std::countr_zero(slots_.size());
  cubes_ = 0;
}

void CubeTable::add(Slot& empty, const Slot& cube) {
  empty = cube;
  if (2 * ++cubes_ <= slots_.size()) return;
  const std::vector<Slot> before = std::move(slots_);
  slots_.assign(2 * before.size(), {});
  --shift_;
  for (const Slot& slot : before) {
    if (slot.cube >= 0) slot_of(slot.key) = slot;
  }
}

}  // namespace mapless
