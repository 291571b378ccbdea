#include "detection/published/box_filter.hpp"

#include <algorithm>
#include <random>

#include <gtest/gtest.h>

#include "oracle/box_filter_oracle.hpp"
#include "support/small_scan.hpp"

namespace mapless {
namespace MAPLESS_FILE {

using test::small_scan;

constexpr int kColumns = test::kSmallColumns;

std::vector<char> none_dynamic(const LidarScan& scan) { return std::vector<char>(scan.returns.size(), 0); }

void set_dynamic(const LidarScan& scan, std::vector<char>& dynamic, int laser,
                 const std::vector<int>& columns) {
  for (const int c : columns) dynamic[static_cast<std::size_t>(scan.cell(laser, c))] = 1;
}

int removed(const std::vector<FilterVerdict>& verdicts) {
  return static_cast<int>(std::count(verdicts.begin(), verdicts.end(), FilterVerdict::removed));
}

// A lone run scores 8 for the empty rows and 1 for each of its pixels; two rows of four lose 4 for each
// other.
TEST(BoxFilter, RemovesLoneRunsByScore) {
  const LidarScan scan = small_scan({0, 0, 0, 0, 0});
  BoxFilterParameters parameters;  // more than 10 of 12
  auto dynamic = none_dynamic(scan);
  set_dynamic(scan, dynamic, 2, {5, 6, 7});
  EXPECT_EQ(removed(filter_boxes(scan, dynamic, parameters)), 3);
  dynamic = none_dynamic(scan);
  set_dynamic(scan, dynamic, 2, {5, 6});
  EXPECT_EQ(removed(filter_boxes(scan, dynamic, parameters)), 0);
  dynamic = none_dynamic(scan);
  set_dynamic(scan, dynamic, 2, {5, 6, 7, 8});
  set_dynamic(scan, dynamic, 3, {5, 6, 7, 8});
  EXPECT_EQ(removed(filter_boxes(scan, dynamic, parameters)), 0);
}

TEST(BoxFilter, TakesTheImageAsEmptyAboveAndBelowAndAsRoundAtItsSides) {
  const LidarScan scan = small_scan({0, 0, 0});
  auto dynamic = none_dynamic(scan);
  set_dynamic(scan, dynamic, 0, {kColumns - 2, kColumns - 1, 0, 1});
  set_dynamic(scan, dynamic, 2, {10, 11, 12, 13});
  EXPECT_EQ(removed(filter_boxes(scan, dynamic, {})), 8);
}

TEST(BoxFilter, TwelveSwitchesItOff) {
  const LidarScan scan = small_scan({0, 0, 0});
  auto dynamic = none_dynamic(scan);
  set_dynamic(scan, dynamic, 1, {10, 11, 12, 13});
  BoxFilterParameters parameters;
  parameters.score_threshold = 12;
  EXPECT_EQ(removed(filter_boxes(scan, dynamic, parameters)), 0);
  parameters.score_threshold = 11;
  EXPECT_EQ(removed(filter_boxes(scan, dynamic, parameters)), 4);
}

// Runs of any length in an otherwise empty image, with returns missing: what the filter is for, and near to
// it.
std::vector<char> random_runs(const LidarScan& scan, std::mt19937_64& random) {
  auto dynamic = none_dynamic(scan);
  const std::size_t runs = 1 + random() % 12;
  for (std::size_t k = 0; k < runs; ++k) {
    const int laser = static_cast<int>(random() % scan.model->lasers.size());
    const int start = static_cast<int>(random() % kColumns);
    const int length = 1 + static_cast<int>(random() % 7);
    for (int c = start; c < start + length; ++c) {
      const std::int32_t cell = scan.cell(laser, c % kColumns);
      if (cell >= 0) dynamic[static_cast<std::size_t>(cell)] = 1;
    }
  }
  return dynamic;
}

TEST(BoxFilter, AgreesWithTheWindowPutEverywhere) {
  int outliers = 0;
  for (unsigned seed = 0; seed < 400; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937_64 random(seed);
    const auto direction = seed % 2 == 0 ? SpinDirection::clockwise : SpinDirection::counter_clockwise;
    const std::vector<double> offsets = {0.2, -3.1, 2.4, 5.3, -0.4, 1.1};
    std::vector<char> missing(offsets.size() * kColumns);
    if (seed % 3 != 0) std::generate(missing.begin(), missing.end(), [&] { return random() % 8 == 0; });
    const LidarScan scan = small_scan(offsets, 5, missing, direction);
    BoxFilterParameters parameters;
    parameters.image = seed % 4 < 2 ? ImageAlignment::aligned : ImageAlignment::raw;
    parameters.score_threshold = 7 + static_cast<int>(seed % 6);
    const std::vector<char> dynamic = random_runs(scan, random);
    const std::vector<char> expected = test::outliers_by_window(scan, dynamic, parameters);
    const std::vector<FilterVerdict> verdicts = filter_boxes(scan, dynamic, parameters);
    ASSERT_EQ(verdicts.size(), dynamic.size());
    for (std::size_t i = 0; i < verdicts.size(); ++i) {
      const FilterVerdict wanted = expected[i] ? FilterVerdict::removed : FilterVerdict::kept;
      ASSERT_EQ(verdicts[i], dynamic[i] ? wanted : FilterVerdict::not_evaluated) << "return " << i;
      outliers += expected[i] ? 1 : 0;
    }
  }
  EXPECT_GT(outliers, 1000);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
