#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <mapless/core/errors.hpp>
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

TEST(Time, SecondsAnInt64CannotHoldAreRefused) {
  EXPECT_NO_THROW((void)Duration::from_seconds(Duration::kMaxSeconds));
  for (const double s : {9.3e9, -9.3e9, std::nan(""), HUGE_VAL}) {
    EXPECT_THROW((void)Duration::from_seconds(s), ParameterError) << s;
    EXPECT_THROW((void)Time::from_seconds(s), ParameterError) << s;
  }
  try {
    (void)(Duration::from_seconds(1e9) * 10);
    ADD_FAILURE() << "accepted";
  } catch (const ParameterError& error) {
    EXPECT_THAT(error.what(),
                testing::AllOf(testing::HasSubstr("s = 1000000000"), testing::HasSubstr("to 9200000000")));
  }
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
