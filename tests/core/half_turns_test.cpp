#include "core/half_turns.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace mapless {
namespace MAPLESS_FILE {

TEST(HalfTurns, AddsTheSectorsOfEachHalfAlsoOverTheSeam) {
  EXPECT_THAT(half_turns(std::array{1, 2, 4, 8}), testing::ElementsAre(1 + 2, 2 + 4, 4 + 8, 8 + 1));
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
