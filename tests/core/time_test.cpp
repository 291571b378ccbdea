#include <gtest/gtest.h>

#include <mapless/core/time.hpp>

namespace mapless {
namespace MAPLESS_FILE {

TEST(Time, SecondsRoundToTheNearestNanosecond) {
  EXPECT_EQ(Time::from_seconds(1.5).nanoseconds(), 1'500'000'000);
  EXPECT_EQ(Duration::from_seconds(-0.3e-9).nanoseconds(), 0);
  EXPECT_EQ(Duration::from_seconds(-0.7e-9).nanoseconds(), -1);
}

TEST(Time, DifferencesAreExactForUnixTimes) {
  const Time a = Time::from_nanoseconds(1'317'042'272'283'701'593);
  EXPECT_EQ((a + Duration::from_nanoseconds(1) - a).nanoseconds(), 1);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
