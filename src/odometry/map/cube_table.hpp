#pragma once

#include <cstdint>
#include <vector>

#include "odometry/map/cube_hash.hpp"

namespace mapless::inline v1 {

/// Where a point lies in a grid. Cubes lie anywhere in memory: for many queries, fetch all slots first, then
/// all cubes, then read these, so that the loads overlap.
struct CubePlace {
  std::uint64_t key = kNoCube;
  std::int32_t cube = -1;  ///< set by fetch_cube; negative if there is no such cube
};

/// The numbers of cubes by their keys: an open-addressing hash table.
class CubeTable {
 public:
  struct Slot {
    std::uint64_t key = 0;
    std::int32_t cube = -1;  ///< negative: empty
    bool full = false;       ///< the cube takes no more points, and need not be read to learn that
  };

  CubeTable() { clear(); }

  /// Keeps the memory.
  void clear();
  /// Loads the slot of a key into the cache.
  void prefetch(std::uint64_t key) const { __builtin_prefetch(&slots_[cube_slot(key, shift_)]); }
  /// The slot of the cube, or the empty slot where it belongs. Valid until the next add().
  [[nodiscard]] const Slot& slot_of(std::uint64_t key) const { return slots_[number_of(key)]; }
  [[nodiscard]] Slot& slot_of(std::uint64_t key) { return slots_[number_of(key)]; }
  /// Adds a cube to the empty slot that slot_of() gave for its key.
  void add(Slot& empty, const Slot& cube);

 private:
  [[nodiscard]] std::size_t number_of(std::uint64_t key) const {
    const std::size_t mask = slots_.size() - 1;
    std::size_t i = cube_slot(key, shift_);
    while (slots_[i].cube >= 0 && slots_[i].key != key) i = (i + 1) & mask;
    return i;
  }

  std::vector<Slot> slots_;  // size a power of two
  std::size_t cubes_ = 0;
  int shift_ = 0;  // leaves the high bits of the hash
};

}  // namespace mapless
