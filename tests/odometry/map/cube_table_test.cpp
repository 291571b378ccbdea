#include "odometry/map/cube_table.hpp"

#include <gtest/gtest.h>

namespace mapless {
namespace MAPLESS_FILE {

// More cubes than an empty table has slots: it grows, and keeps every one of them.
TEST(CubeTable, FindsEveryCubeAndNoOther) {
  constexpr std::int32_t kCubes = 20000;
  const auto key_of = [](std::int32_t cube) { return std::uint64_t{7} * static_cast<std::uint64_t>(cube); };
  CubeTable table;
  for (std::int32_t cube = 0; cube < kCubes; ++cube) {
    CubeTable::Slot& slot = table.slot_of(key_of(cube));
    ASSERT_LT(slot.cube, 0);
    table.add(slot, {key_of(cube), cube, cube % 3 == 0});
  }
  for (std::int32_t cube = 0; cube < kCubes; ++cube) {
    ASSERT_EQ(table.slot_of(key_of(cube)).cube, cube);
    ASSERT_EQ(table.slot_of(key_of(cube)).full, cube % 3 == 0);
    ASSERT_LT(table.slot_of(key_of(cube) + 1).cube, 0);
  }
  table.clear();
  for (std::int32_t cube = 0; cube < kCubes; ++cube) ASSERT_LT(table.slot_of(key_of(cube)).cube, 0);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
