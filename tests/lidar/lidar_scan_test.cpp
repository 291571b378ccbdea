#include <algorithm>
#include <limits>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <mapless/core/errors.hpp>
#include <mapless/lidar/lidar_scan.hpp>

namespace mapless {
namespace MAPLESS_FILE {

constexpr int kColumns = 90;

// Two lasers, one 1 m beside the axis, so that ranges are not distances from the sensor's origin.
LidarScan empty_scan() {
  auto model = std::make_shared<LidarModel>();
  model->columns = kColumns;
  model->max_range_m = 100;
  model->lasers.resize(2);
  model->lasers[1].elevation_rad = 0.1;
  model->lasers[1].origin_h_m = {0, 1, 0};
  LidarScan scan;
  scan.model = std::move(model);
  scan.start = Time::from_seconds(5);
  scan.column_period = Duration::from_nanoseconds(1'000'000);
  scan.columns = kColumns;
  return scan;
}

LidarRecord record(int laser, int column, float range_m, ReturnCode code = ReturnCode::hit) {
  const LidarScan scan = empty_scan();
  return {scan.model->point_v(laser, column, static_cast<double>(range_m)).cast<float>(), laser, column,
          column * 1'000'000, code};
}

LidarScan organised(const std::vector<LidarRecord>& records) {
  return organise(empty_scan(), records, "test.pcd");
}

std::string refusal(const LidarRecord& bad) {
  try {
    (void)organised({record(0, 0, 5), bad});
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(Organise, ReturnsAreSortedByLaserColumnAndInputIndex) {
  const LidarScan scan = organised({record(1, 3, 9), record(0, 7, 4), record(0, 2, 6), record(0, 7, 5)});
  ASSERT_EQ(scan.returns.size(), 4u);
  std::vector<std::uint32_t> order;
  for (const LidarReturn& r : scan.returns) order.push_back(r.input_index);
  EXPECT_EQ(order, (std::vector<std::uint32_t>{2, 1, 3, 0}));
  EXPECT_EQ(scan.input_size, 4u);
  EXPECT_EQ(scan.returns[1].column, 7);
  EXPECT_EQ(scan.returns[1].time_ns, 7'000'000);
  EXPECT_EQ(scan.time_of(scan.returns[1]), scan.column_time(7));
  EXPECT_EQ(scan.cells.size(), 2u * kColumns);
}

TEST(Organise, RangesAreDistancesFromTheOriginOfTheLaser) {
  const LidarScan scan = organised({record(1, 33, 9), record(0, 33, 4)});
  EXPECT_NEAR(scan.returns[0].range_m, 4, 1e-6);
  EXPECT_NEAR(scan.returns[1].range_m, 9, 1e-6);
  EXPECT_GT(scan.returns[1].position_v.norm(), 9.04);
}

TEST(Organise, ACellHoldsTheNearerReturnAndTheFirstOfEquals) {
  const LidarScan scan =
      organised({record(0, 1, 8), record(0, 1, 3), record(0, 1, 5), record(1, 1, 6), record(1, 1, 6)});
  EXPECT_EQ(scan.returns[static_cast<std::size_t>(scan.cell(0, 1))].input_index, 1u);
  EXPECT_EQ(scan.returns[static_cast<std::size_t>(scan.cell(1, 1))].input_index, 3u);
}

TEST(Organise, CellsWithoutReturnKeepTheirCode) {
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  LidarRecord not_a_number = record(0, 4, 5), infinite = record(0, 5, 5);
  not_a_number.position_v.y() = nan;
  infinite.position_v.x() = inf;
  const LidarScan scan = organised({record(0, 1, 1, ReturnCode::faulty), record(0, 2, 1, ReturnCode::nothing),
                                    record(0, 3, 1, ReturnCode::absent), not_a_number, infinite,
                                    record(1, 6, 0.009f), record(1, 7, 0.011f)});
  EXPECT_EQ(code_of_cell(scan.cell(0, 0)), ReturnCode::absent);
  EXPECT_EQ(code_of_cell(scan.cell(0, 1)), ReturnCode::faulty);
  EXPECT_EQ(code_of_cell(scan.cell(0, 2)), ReturnCode::nothing);
  EXPECT_EQ(code_of_cell(scan.cell(0, 3)), ReturnCode::absent);
  EXPECT_EQ(code_of_cell(scan.cell(0, 4)), ReturnCode::faulty);
  EXPECT_EQ(code_of_cell(scan.cell(0, 5)), ReturnCode::faulty);
  EXPECT_EQ(code_of_cell(scan.cell(1, 6)), ReturnCode::faulty);
  EXPECT_EQ(code_of_cell(scan.cell(1, 7)), ReturnCode::hit);
  EXPECT_EQ(scan.input_size, 7u);
  EXPECT_EQ(scan.returns.size(), 1u);
}

TEST(Organise, OfSeveralCodesTheWeakestClaimIsKept) {
  const LidarScan scan =
      organised({record(0, 1, 1, ReturnCode::nothing), record(0, 1, 1, ReturnCode::faulty),
                 record(0, 1, 1, ReturnCode::nothing), record(0, 2, 1, ReturnCode::nothing), record(0, 2, 7),
                 record(0, 2, 1, ReturnCode::faulty)});
  EXPECT_EQ(code_of_cell(scan.cell(0, 1)), ReturnCode::faulty);
  EXPECT_EQ(code_of_cell(scan.cell(0, 2)), ReturnCode::hit);
}

TEST(Organise, NoRecordsGiveAnEmptyImage) {
  const LidarScan scan = organised({});
  EXPECT_TRUE(scan.returns.empty());
  EXPECT_TRUE(std::all_of(scan.cells.begin(), scan.cells.end(),
                          [](std::int32_t c) { return code_of_cell(c) == ReturnCode::absent; }));
}

TEST(Organise, RefusesRecordsOutsideTheImage) {
  using ::testing::AllOf;
  using ::testing::HasSubstr;
  LidarRecord bad = record(0, 0, 5);
  bad.laser = 2;
  EXPECT_THAT(refusal(bad),
              AllOf(HasSubstr("test.pcd"), HasSubstr("record 1 laser = 2"), HasSubstr("0 to 1")));
  bad.laser = -1;
  EXPECT_THAT(refusal(bad), HasSubstr("laser = -1"));
  bad = record(0, 0, 5);
  bad.column = kColumns;
  EXPECT_THAT(refusal(bad), HasSubstr("column = 90"));
  bad = record(0, 0, 5);
  bad.time_ns = 2'000'000'000;
  EXPECT_THAT(refusal(bad), HasSubstr("time [ns] = 2000000000"));
  LidarScan scan = empty_scan();
  scan.column_period = Duration();
  EXPECT_THROW((void)organise(scan, {}, "test.pcd"), InputError);
}

TEST(Organise, RefusesPointsBeyondAnyLidarAndTimesBeyondArithmetic) {
  EXPECT_EQ(refusal(record(0, 1, 9'999)), "accepted");
  EXPECT_THAT(refusal(record(0, 1, 60'000)),
              ::testing::AllOf(::testing::HasSubstr("test.pcd: record 1 range = 60000 m"),
                               ::testing::HasSubstr("in metres")));
  EXPECT_THAT(refusal(record(0, 1, 1e38f)), ::testing::HasSubstr("record 1 range = 1e+38 m"));
  LidarScan late = empty_scan();
  late.start = Time::from_nanoseconds(std::numeric_limits<std::int64_t>::max() - 1);
  EXPECT_THROW((void)organise(late, {}, "test.pcd"), InputError);
}

TEST(Organise, EqualsAStableSortOfRandomRecords) {
  for (unsigned seed = 0; seed < 5; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 rng(seed);
    std::vector<LidarRecord> records;
    for (int i = 0; i < 500; ++i) {
      records.push_back(record(static_cast<int>(rng() % 2), static_cast<int>(rng() % kColumns),
                               1.0f + static_cast<float>(rng() % 100)));
    }
    std::vector<std::uint32_t> order(records.size());
    for (std::uint32_t i = 0; i < order.size(); ++i) order[i] = i;
    std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
      return std::pair(records[a].laser, records[a].column) < std::pair(records[b].laser, records[b].column);
    });
    const LidarScan scan = organised(records);
    ASSERT_EQ(scan.returns.size(), order.size());
    for (std::size_t i = 0; i < order.size(); ++i) EXPECT_EQ(scan.returns[i].input_index, order[i]);
  }
}

TEST(Organise, RefusesAScanWithoutAValidModel) {
  LidarScan scan;
  scan.columns = 1;
  scan.column_period = Duration::from_nanoseconds(1);
  EXPECT_THROW((void)organise(scan, {}, "test"), ParameterError);
  scan.model = std::make_shared<const LidarModel>();
  EXPECT_THROW((void)organise(scan, {}, "test"), InputError);
  scan.model = std::make_shared<const LidarModel>(named_model("VLP-16"));
  EXPECT_NO_THROW((void)organise(scan, {}, "test"));
  scan.columns = 1'000'001;
  EXPECT_THROW((void)organise(scan, {}, "test"), InputError);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
