#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/memory_dataset.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/dataset.hpp>

namespace mapless {
namespace MAPLESS_FILE {

using testing::AllOf;
using testing::HasSubstr;

std::string refusal(const std::vector<double>& starts_s, std::size_t first, std::size_t count) {
  std::vector<Time> starts;
  for (const double s : starts_s) starts.push_back(Time::from_seconds(s));
  try {
    require_time_order(test::MemoryDataset(starts, 4), first, count);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(TimeOrder, NamesTheFirstScanThatDoesNotStartAfterTheOneBefore) {
  EXPECT_EQ(refusal({0, 0.1, 0.2}, 0, 3), "");
  EXPECT_EQ(refusal({5}, 0, 1), "");
  EXPECT_THAT(refusal({0, 0.1, 0.1, 0.2}, 0, 4),
              AllOf(HasSubstr("memory: start of scan 2 = 0.100000000 s"), HasSubstr("that of scan 1")));
  EXPECT_THAT(refusal({0, 0.2, 0.1}, 0, 3), HasSubstr("scan 2"));
}

TEST(TimeOrder, ChecksTheChosenScansOnly) {
  EXPECT_EQ(refusal({0, 0.2, 0.1, 0.3, 0.25}, 2, 2), "");
  EXPECT_EQ(refusal({0, 0.2, 0.1, 0.3}, 0, 2), "");
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
