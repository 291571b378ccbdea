#include <cmath>

#include <gtest/gtest.h>

#include <mapless/core/errors.hpp>
#include <mapless/evaluation/trajectory_evaluation.hpp>

namespace mapless {
namespace MAPLESS_FILE {

TEST(Quantile, InterpolatesBetweenRanks) {
  EXPECT_DOUBLE_EQ(*quantile({4, 1, 3, 2}, 0.5), 2.5);
  EXPECT_DOUBLE_EQ(*quantile({5, 1, 3}, 0.5), 3);
  EXPECT_DOUBLE_EQ(*quantile({0, 10, 20, 30, 40}, 0.95), 38);
  EXPECT_DOUBLE_EQ(*quantile({7}, 0.99), 7);
  EXPECT_DOUBLE_EQ(*quantile({1, 9}, 1.0), 9);
}

TEST(Quantile, IsAbsentForNoValues) { EXPECT_FALSE(quantile({}, 0.5)); }

TEST(Quantile, RefusesOrdersOutsideZeroToOne) {
  for (const double q : {-0.1, 1.1, std::nan("")}) EXPECT_THROW((void)quantile({1, 2}, q), ParameterError);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
