#include "reports/duration_histogram.hpp"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

namespace mapless::app {
namespace MAPLESS_FILE {

TEST(DurationHistogram, QuantilesAreWithinHalfAPercentOfTheExactOnes) {
  DurationHistogram histogram;
  EXPECT_FALSE(histogram.quantile(0.5));
  std::vector<double> seconds;  // increasing, from 10 us to 100 s
  for (int i = 0; i <= 1000; ++i) seconds.push_back(1e-5 * std::pow(10, 0.007 * i));
  for (const double s : seconds) histogram.add(s);
  for (const double q : {0.0, 0.25, 0.5, 0.95, 1.0}) {
    const double exact = seconds[static_cast<std::size_t>(std::lround(1000 * q))];
    EXPECT_NEAR(*histogram.quantile(q), exact, 0.0051 * exact) << q;
  }
}

TEST(DurationHistogram, TakesDurationsOutsideItsRange) {
  DurationHistogram histogram;
  for (const double s : {0.0, -1.0, 1e9}) histogram.add(s);
  EXPECT_EQ(*histogram.quantile(0), 0);
  EXPECT_NEAR(*histogram.quantile(1), 1000, 10);
  EXPECT_EQ(histogram.size(), 3u);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless::app
