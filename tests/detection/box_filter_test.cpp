#include <algorithm>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "oracle/box_filter_oracle.hpp"
#include "support/toy_scene.hpp"
#include <mapless/detection/box_filter.hpp>

namespace mapless {
namespace {

constexpr int kColumns = 24;

/// A scan of few lasers and columns, all returns 5 m away, except that a ray in `missing_in` never came back.
LidarScan small_scan(const std::vector<double>& offsets_in_columns, SpinDirection direction, unsigned seed,
                     int missing_in) {
  auto model = std::make_shared<LidarModel>();
  model->columns = kColumns;
  model->direction = direction;
  model->max_range_m = 100;
  std::vector<LidarRecord> records;
  std::mt19937_64 random(seed);
  for (std::size_t l = 0; l < offsets_in_columns.size(); ++l) {
    Laser laser;
    laser.elevation_rad = 0.01 * static_cast<double>(l);
    laser.azimuth_offset_rad = offsets_in_columns[l] * model->sign() * 2 * std::numbers::pi / kColumns;
    model->lasers.push_back(laser);
  }
  for (int l = 0; l < static_cast<int>(offsets_in_columns.size()); ++l) {
    for (int c = 0; c < kColumns; ++c) {
      const bool missing = missing_in > 0 && random() % static_cast<unsigned>(missing_in) == 0;
      records.push_back(
          {model->point_v(l, c, 5).cast<float>(), l, c, c, missing ? ReturnCode::faulty : ReturnCode::hit});
    }
  }
  LidarScan scan;
  scan.model = model;
  scan.columns = kColumns;
  scan.column_period = Duration::from_nanoseconds(1000);
  return organise(scan, records, "test");
}

std::vector<char> none_dynamic(const LidarScan& scan) { return std::vector<char>(scan.returns.size(), 0); }

void set_dynamic(const LidarScan& scan, std::vector<char>& dynamic, int laser,
                 const std::vector<int>& columns) {
  for (const int c : columns) dynamic[static_cast<std::size_t>(scan.cell(laser, c))] = 1;
}

int removed(const std::vector<BoxVerdict>& verdicts) {
  return static_cast<int>(std::count(verdicts.begin(), verdicts.end(), BoxVerdict::removed));
}

// A lone run scores 8 for the empty rows and 1 for each of its pixels; two rows of four lose 4 for each
// other.
TEST(BoxFilter, RemovesLoneRunsByScore) {
  const LidarScan scan = small_scan({0, 0, 0, 0, 0}, SpinDirection::clockwise, 1, 0);
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
  const LidarScan scan = small_scan({0, 0, 0}, SpinDirection::clockwise, 1, 0);
  auto dynamic = none_dynamic(scan);
  set_dynamic(scan, dynamic, 0, {kColumns - 2, kColumns - 1, 0, 1});
  set_dynamic(scan, dynamic, 2, {10, 11, 12, 13});
  EXPECT_EQ(removed(filter_boxes(scan, dynamic, {})), 8);
}

TEST(BoxFilter, TwelveSwitchesItOff) {
  const LidarScan scan = small_scan({0, 0, 0}, SpinDirection::clockwise, 1, 0);
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
    const LidarScan scan =
        small_scan({0.2, -3.1, 2.4, 5.3, -0.4, 1.1}, direction, seed, seed % 3 == 0 ? 0 : 8);
    BoxFilterParameters parameters;
    parameters.image = seed % 4 < 2 ? ImageAlignment::aligned : ImageAlignment::raw;
    parameters.score_threshold = 7 + static_cast<int>(seed % 6);
    const std::vector<char> dynamic = random_runs(scan, random);
    const std::vector<char> expected = test::outliers_by_window(scan, dynamic, parameters);
    const std::vector<BoxVerdict> verdicts = filter_boxes(scan, dynamic, parameters);
    ASSERT_EQ(verdicts.size(), dynamic.size());
    for (std::size_t i = 0; i < verdicts.size(); ++i) {
      const BoxVerdict asked = expected[i] ? BoxVerdict::removed : BoxVerdict::kept;
      ASSERT_EQ(verdicts[i], dynamic[i] ? asked : BoxVerdict::not_asked) << "return " << i;
      outliers += expected[i] ? 1 : 0;
    }
  }
  EXPECT_GT(outliers, 1000);
}

}  // namespace
}  // namespace mapless
