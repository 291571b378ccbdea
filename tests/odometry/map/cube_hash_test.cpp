#include "odometry/map/cube_hash.hpp"

#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

namespace mapless {
namespace MAPLESS_FILE {

// Cube n extends from n - 1/2 to n + 1/2, for negative n too.
TEST(CubeHash, CubesAreNumberedByTheirMiddles) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> anywhere(-1000, 1000), inside(-0.499999, 0.499999);
  for (int i = 0; i < 1000; ++i) {
    const int x = static_cast<int>(anywhere(random)), y = static_cast<int>(anywhere(random)),
              z = static_cast<int>(anywhere(random));
    const auto key = cube_key(x + inside(random), y + inside(random), z + inside(random));
    ASSERT_EQ(cube_number(key, 0), x);
    ASSERT_EQ(cube_number(key, 1), y);
    ASSERT_EQ(cube_number(key, 2), z);
    ASSERT_LT(key, std::uint64_t{1} << 63U);
    ASSERT_EQ(nearest_integer(x + inside(random)), x);
  }
}

TEST(CubeHash, NoCubeBeyondHalfAnAxis) {
  const double last = kHalfAxis - 1;
  EXPECT_EQ(cube_number(cube_key(last, 0, -last - 1), 0), kHalfAxis - 1);
  EXPECT_EQ(cube_number(cube_key(last, 0, -last - 1), 2), -kHalfAxis);
  const double nan = std::numeric_limits<double>::quiet_NaN(), infinite = HUGE_VAL;
  for (const double outside :
       {last + 1, -last - 2, 1e15, -1e15, 5e15, -5e15, 1e300, -1e300, infinite, -infinite, nan, -nan}) {
    SCOPED_TRACE(outside);
    EXPECT_EQ(cube_key(outside, 0, 0), kNoCube);
    EXPECT_EQ(cube_key(0, outside, 0), kNoCube);
    EXPECT_EQ(cube_key(0, 0, outside), kNoCube);
  }
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
