#include "lidar/recovery/ring_recovery.hpp"

#include <cmath>
#include <limits>
#include <set>

#include <gtest/gtest.h>

#include "support/bare_cloud.hpp"
#include <mapless/core/errors.hpp>

namespace mapless {
namespace MAPLESS_FILE {

using test::Cloud;
using test::make_bare_cloud;
using test::make_bare_cloud_model;

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

// Rows of a cloud of full rings of `columns` points, top first.
std::vector<std::int32_t> true_rows(const Cloud& cloud, int lasers, int columns) {
  std::vector<std::int32_t> rows;
  for (std::size_t i = 0; i < cloud.size(); ++i) rows.push_back(lasers - 1 - static_cast<int>(i) / columns);
  return rows;
}

// The points of `cloud` whose index `keep` accepts, and their true rows.
template <class Keep>
std::pair<Cloud, std::vector<std::int32_t>> some_of(const Cloud& cloud, const std::vector<std::int32_t>& rows,
                                                    Keep keep) {
  std::pair<Cloud, std::vector<std::int32_t>> kept;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (!keep(i)) continue;
    kept.first.push_back(cloud[i]);
    kept.second.push_back(rows[i]);
  }
  return kept;
}

TEST(RingStarts, ARingStartsWhereTheAzimuthDrops) {
  const LidarModel model = make_bare_cloud_model(16, 500);
  const std::vector<std::size_t> starts = ring_starts(make_bare_cloud(model, 0));
  ASSERT_EQ(starts.size(), 16U);
  for (std::size_t i = 0; i < starts.size(); ++i) EXPECT_EQ(starts[i], 500 * i);
}

TEST(RingStarts, SmallBackwardStepsAndPointsJustBeforeTheFrontStartNoRing) {
  // The last point lies on the front itself, a hair to the right.
  const Cloud cloud = {{1, 0.1F, 0},  {1, 0.3F, 0},  {1, 0.29F, 0}, {-1, 0, 0},
                       {1, -0.1F, 0}, {1, -0.0F, 0}, {1, 0.2F, 0}};
  EXPECT_EQ(ring_starts(cloud), (std::vector<std::size_t>{0, 6}));
}

TEST(RingStarts, UnusablePointsStayInTheirRing) {
  const Cloud cloud = {{kNaN, 0, 0},  {1, 0.1F, 0},       {0, 0, 0},
                       {1, -0.1F, 0}, {kNaN, kNaN, kNaN}, {1, 0.1F, 0}};
  EXPECT_EQ(ring_starts(cloud), (std::vector<std::size_t>{0, 5}));
  EXPECT_TRUE(ring_starts({}).empty());
  EXPECT_TRUE(ring_starts({{kNaN, kNaN, kNaN}}).empty());
}

TEST(RingStarts, PointsRoundedAcrossTheFrontStayInTheirRing) {
  // Every ring has a point on the front, here a hair to its right: at the start of its ring or at the end.
  for (const bool at_start : {true, false}) {
    SCOPED_TRACE(at_start);
    Cloud cloud;
    for (int ring = 0; ring < 3; ++ring) {
      const float z = -0.1F * static_cast<float>(ring);
      if (at_start) cloud.emplace_back(1, -1e-5F, z);
      for (int i = 1; i < 20; ++i) {
        const float a = static_cast<float>(i) * 0.3F;
        cloud.emplace_back(std::cos(a), std::sin(a), z);
      }
      if (!at_start) cloud.emplace_back(1, 1e-5F, z);
    }
    EXPECT_EQ(ring_starts(cloud), (std::vector<std::size_t>{0, 20, 40}));
  }
}

// Lasers beside the axis see near and far things alternately: the azimuths of a ring pass the front twice.
TEST(RingStarts, ARingThatPassesTheFrontTwiceIsOne) {
  Cloud cloud;
  for (int ring = 0; ring < 3; ++ring) {
    const float z = -0.3F * static_cast<float>(ring);
    for (int i = 1; i < 21; ++i) {
      const float a = static_cast<float>(i) * 0.3F;
      cloud.emplace_back(2 * std::cos(a), 2 * std::sin(a), z);
    }
    cloud.emplace_back(2, -4e-3F, z);
    cloud.emplace_back(2, 2e-3F, z);
    cloud.emplace_back(2, -1e-3F, z);
  }
  EXPECT_EQ(ring_starts(cloud), (std::vector<std::size_t>{0, 23, 46}));
}

TEST(RecoverLasers, RingsFollowFromTheOrderAlone) {
  const LidarModel model = make_bare_cloud_model(16, 500);
  const Cloud cloud = make_bare_cloud(model, 0);
  EXPECT_EQ(recover_lasers(cloud, model, top_first_layout(model), "cloud"), true_rows(cloud, 16, 500));
}

TEST(RecoverLasers, AMissingRingIsFoundFromTheBeams) {
  const LidarModel model = make_bare_cloud_model(16, 500);
  const Cloud whole = make_bare_cloud(model, 0);
  const auto [cloud, rows] =
      some_of(whole, true_rows(whole, 16, 500), [](std::size_t i) { return i / 500 != 5 && i / 500 != 15; });
  EXPECT_EQ(ring_starts(cloud).size(), 14U);
  EXPECT_EQ(recover_lasers(cloud, model, top_first_layout(model), "cloud"), rows);
}

TEST(RecoverLasers, MergedRingsAreSeparated) {
  const LidarModel model = make_bare_cloud_model(16, 500);
  const Cloud whole = make_bare_cloud(model, 0);
  // Of the top ring only the first tenth is left, of the second one only what comes after that.
  const auto [cloud, rows] =
      some_of(whole, true_rows(whole, 16, 500), [](std::size_t i) { return i < 50 || i >= 550; });
  EXPECT_EQ(ring_starts(cloud).size(), 15U);
  EXPECT_EQ(recover_lasers(cloud, model, top_first_layout(model), "cloud"), rows);
}

TEST(RecoverLasers, RefusesCloudsNotStoredByRing) {
  const LidarModel model = make_bare_cloud_model(16, 500);
  Cloud cloud = make_bare_cloud(model, 0);
  std::reverse(cloud.begin(), cloud.end());
  try {
    (void)recover_lasers(cloud, model, top_first_layout(model), "scan.bin");
    FAIL() << "accepted";
  } catch (const InputError& error) {
    EXPECT_EQ(error.detail().where, "scan.bin");
    EXPECT_EQ(error.detail().field, "rings");
  }
}

TEST(RecoverFirings, ColumnsAndTurnOfAnEvenGrid) {
  const LidarModel model = make_bare_cloud_model(16, 500);
  const Cloud cloud = make_bare_cloud(model, 0);
  const RecoveredFirings firings = recover_firings(cloud, true_rows(cloud, 16, 500), model, 0);
  EXPECT_LT(firings.residual_columns_rms, 1e-3);
  std::set<std::pair<int, int>> cells;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const auto row = static_cast<int>(true_rows(cloud, 16, 500)[i]);
    cells.emplace(row, firings.columns[i]);
    EXPECT_NEAR(firings.turn[i], firings.columns[i] / 500.0, 1e-5);
  }
  EXPECT_EQ(cells.size(), cloud.size());
}

TEST(RecoverFirings, WithoutOffsetsTimeFollowsTheAzimuth) {
  LidarModel model = make_bare_cloud_model(2, 2000);
  for (Laser& laser : model.lasers) {
    laser.azimuth_offset_rad = 0;
    laser.origin_h_m.setZero();
  }
  // Left, front, right, and either side of the seam: (1 - azimuth / pi) / 2.
  const Cloud cloud = {{0, 5, 0}, {5, 0, 0}, {0, -5, 0}, {-5, 1e-4F, 0}, {-5, -1e-4F, 0}};
  const RecoveredFirings f = recover_firings(cloud, {0, 0, 0, 0, 0}, model, 0);
  EXPECT_NEAR(f.turn[0], 0.25, 1e-6);
  EXPECT_NEAR(f.turn[1], 0.5, 1e-6);
  EXPECT_NEAR(f.turn[2], 0.75, 1e-6);
  EXPECT_NEAR(f.turn[3], 0, 1e-4);
  EXPECT_NEAR(f.turn[4], 0, 1e-4);  // column 0 is nearest, so its time
  EXPECT_EQ(f.columns, (std::vector<std::int32_t>{500, 1000, 1500, 0, 0}));
}

// Also where the points without a position go on over several parts of the work.
TEST(RecoverFirings, PointsWithoutPositionGetTheColumnOfTheLastOneBefore) {
  const LidarModel model = make_bare_cloud_model(16, 3000);
  Cloud cloud = make_bare_cloud(model, 0);
  const std::vector<std::int32_t> rows = true_rows(cloud, 16, 3000);
  const std::vector<std::int32_t> whole = recover_columns(cloud, rows, model, 0);
  const std::size_t first = 5000, last = 30000;  // a part is 8192 points
  for (std::size_t i = 0; i < 10; ++i) cloud[i].setZero();
  for (std::size_t i = first; i < last; ++i) cloud[i].setConstant(kNaN);
  const std::vector<std::int32_t> columns = recover_columns(cloud, rows, model, 0);
  ASSERT_EQ(columns.size(), 16U * 3000U);
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const std::int32_t expected = i < 10 ? 0 : whole[i >= first && i < last ? first - 1 : i];
    ASSERT_EQ(columns[i], expected) << i;
  }
  EXPECT_EQ(recover_firings(cloud, rows, model, 0).columns, columns);
}

TEST(RecoverFirings, EveryFiringOfAnEncoderGetsItsOwnColumn) {
  const LidarModel model = make_bare_cloud_model(8, 2152);
  const Cloud cloud = make_bare_cloud(model, 4000);
  const std::vector<std::int32_t> rows = true_rows(cloud, 8, 2152);
  const RecoveredFirings firings = recover_firings(cloud, rows, model, 4000);
  std::set<std::pair<int, int>> cells;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    cells.emplace(rows[i], firings.columns[i]);
    EXPECT_EQ(firings.turn[i], firings.columns[i] / 2152.0);
  }
  EXPECT_EQ(cells.size(), cloud.size());
  EXPECT_LT(firings.residual_columns_rms, 1.0);
}

TEST(RecoverFirings, ColumnAndTimeBelongTogetherAtTheSeam) {
  constexpr int kColumns = 2000;
  for (const SpinDirection direction : {SpinDirection::clockwise, SpinDirection::counter_clockwise}) {
    for (const int encoder_steps : {0, 4000}) {
      SCOPED_TRACE(encoder_steps * static_cast<int>(direction));
      LidarModel model = make_bare_cloud_model(4, kColumns);
      model.direction = direction;
      Cloud cloud;
      std::vector<std::int32_t> rows;
      for (std::int32_t row = 0; row < 4; ++row) {
        for (int hundredths = -300; hundredths <= 300; ++hundredths) {
          cloud.push_back(model.point_v(row, 0.01 * hundredths, 20).cast<float>());
          rows.push_back(row);
        }
      }
      const RecoveredFirings firings = recover_firings(cloud, rows, model, encoder_steps);
      for (std::size_t i = 0; i < cloud.size(); ++i) {
        ASSERT_NEAR(firings.turn[i] * kColumns, firings.columns[i], 1) << "point " << i;
        ASSERT_GE(firings.turn[i], 0);
        ASSERT_LT(firings.turn[i], 1);
      }
    }
  }
}

TEST(RecoverRecords, ReturnsHaveTheTimeOfTheirColumn) {
  const LidarModel model = make_bare_cloud_model(16, 500);
  for (const int encoder_steps : {0, 1000}) {
    SCOPED_TRACE(encoder_steps);
    BareCloudLayout layout = top_first_layout(model);
    layout.encoder_steps = encoder_steps;
    const auto records = recover_records(make_bare_cloud(model, encoder_steps), model, layout,
                                         Duration::from_seconds(0.1), "cloud");
    for (const LidarRecord& r : records) ASSERT_NEAR(r.time_ns, r.column * 200'000, 200'000);
  }
}

TEST(RecoverRecords, UnusablePointsAreFaultyAndKeepTheirPlace) {
  const LidarModel model = make_bare_cloud_model(16, 500);
  Cloud cloud = make_bare_cloud(model, 0);
  cloud[0] = {kNaN, kNaN, kNaN};
  cloud[700] = {0, 0, 0};
  cloud[800] = {std::numeric_limits<float>::infinity(), 0, 0};
  const auto records =
      recover_records(cloud, model, top_first_layout(model), Duration::from_seconds(0.1), "cloud");
  ASSERT_EQ(records.size(), cloud.size());
  for (std::size_t i = 0; i < records.size(); ++i) {
    const bool usable = i != 0 && i != 700 && i != 800;
    EXPECT_EQ(records[i].code, usable ? ReturnCode::hit : ReturnCode::faulty);
    EXPECT_EQ(records[i].laser, 15 - static_cast<int>(i) / 500);
    EXPECT_GE(records[i].time_ns, 0);
    EXPECT_LT(records[i].time_ns, 100'000'000);
  }
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
