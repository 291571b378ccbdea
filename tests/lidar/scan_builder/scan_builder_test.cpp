#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/toy_scene.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/lidar/scan_builder.hpp>

namespace mapless {
namespace MAPLESS_FILE {

using testing::AllOf;
using testing::HasSubstr;

constexpr double kTurn_rad = 2 * std::numbers::pi;
const Time kStamp = Time::from_nanoseconds(1'700'000'000'000'000'000);

// The points of a scan as arrays, in an order of their own.
struct Points {
  std::vector<LidarRecord> truth;  // of point i
  std::vector<float> x, y, z;
  std::vector<std::uint16_t> ring;
  std::vector<std::int64_t> time_ns;  // since the stamp

  [[nodiscard]] PointFields fields() const {
    PointFields fields;
    fields.x = std::span<const float>(x);
    fields.y = std::span<const float>(y);
    fields.z = std::span<const float>(z);
    fields.ring = std::span<const std::uint16_t>(ring);
    fields.time = std::span<const std::int64_t>(time_ns);
    fields.time_unit = TimeUnit::nanoseconds;
    return fields;
  }
};

Points points_of(const std::vector<LidarRecord>& records) {
  Points points;
  points.truth = records;
  for (const LidarRecord& r : records) {
    points.x.push_back(r.position_v.x());
    points.y.push_back(r.position_v.y());
    points.z.push_back(r.position_v.z());
    points.ring.push_back(static_cast<std::uint16_t>(r.laser));
    points.time_ns.push_back(r.time_ns);
  }
  return points;
}

// A room, seen by a sensor on a car that drives a curve: every ray is cast from its own pose.
test::ToyScene room(const char* sensor, int columns) {
  return with_columns(test::toy_room(sensor, test::drive(2, 0.3)), columns);
}

Points shuffled(const test::ToyScene& scene, int number = 0) {
  std::vector<LidarRecord> records = test::cast_scan(scene, number).records;
  std::erase_if(records, [](const LidarRecord& r) { return r.code != ReturnCode::hit; });
  std::mt19937 random(7);
  std::shuffle(records.begin(), records.end(), random);
  return points_of(records);
}

// Every point in the column and row it was cast from.
void expect_own_cells(const LidarScan& scan, const Points& points) {
  ASSERT_EQ(scan.returns.size(), points.truth.size());
  ASSERT_EQ(scan.input_size, points.truth.size());
  for (const LidarReturn& r : scan.returns) {
    const LidarRecord& truth = points.truth[r.input_index];
    ASSERT_EQ(r.laser, truth.laser) << r.input_index;
    ASSERT_EQ(r.column, truth.column) << r.input_index;
    ASSERT_EQ(r.position_v, truth.position_v) << r.input_index;
  }
}

void expect_own_times(const LidarScan& scan, const Points& points, double tolerance_ns) {
  for (const LidarReturn& r : scan.returns) {
    const auto time_ns = static_cast<double>((scan.time_of(r) - kStamp).nanoseconds());
    ASSERT_NEAR(time_ns, static_cast<double>(points.truth[r.input_index].time_ns), tolerance_ns);
  }
}

class ScanBuilderOf : public testing::TestWithParam<const char*> {};

TEST_P(ScanBuilderOf, ShuffledPointsComeBackToTheirColumnsAndLasers) {
  const test::ToyScene scene = room(GetParam(), 600);
  const Points points = shuffled(scene);
  const LidarScan scan = ScanBuilder(*scene.model).build(points.fields(), kStamp);
  expect_own_cells(scan, points);
  expect_own_times(scan, points, 0);
  EXPECT_EQ(scan.ring_source, Provenance::sensor);
  EXPECT_EQ(scan.time_source, Provenance::sensor);
}

TEST_P(ScanBuilderOf, WithoutTimesTheAzimuthsGiveTheColumns) {
  const test::ToyScene scene = room(GetParam(), 600);
  const Points points = shuffled(scene);
  PointFields fields = points.fields();
  fields.time = {};
  const LidarScan scan = ScanBuilder(*scene.model).build(fields, kStamp);
  expect_own_cells(scan, points);
  expect_own_times(scan, points, 600);  // the period of 600 columns, rounded to a nanosecond
  EXPECT_EQ(scan.start, kStamp);
  EXPECT_EQ(scan.time_source, Provenance::recovered_from_angle);
}

INSTANTIATE_TEST_SUITE_P(Sensors, ScanBuilderOf, testing::Values("VLP-16", "HDL-32E", "OS1-64"));

TEST(ScanBuilder, WithoutRingsTheElevationsGiveTheLasers) {
  const test::ToyScene scene = room("VLP-16", 600);
  const Points points = shuffled(scene);
  PointFields fields = points.fields();
  fields.ring = {};
  const LidarScan scan = ScanBuilder(*scene.model).build(fields, kStamp);
  expect_own_cells(scan, points);
  EXPECT_EQ(scan.ring_source, Provenance::recovered_from_angle);
}

TEST(ScanBuilder, RingsMayCountFromTheTop) {
  const test::ToyScene scene = room("VLP-16", 600);
  Points points = shuffled(scene);
  for (std::uint16_t& ring : points.ring) ring = static_cast<std::uint16_t>(15 - ring);
  expect_own_cells(ScanBuilder(*scene.model).build(points.fields(), kStamp), points);
}

// As drivers send them: interleaved, not aligned, doubles, times in seconds of 4 bytes.
TEST(ScanBuilder, FieldsMayBeInterleavedAndUnaligned) {
  const test::ToyScene scene = room("VLP-16", 600);
  const Points points = shuffled(scene);
  const std::size_t count = points.truth.size();
  constexpr std::size_t kStride = 3 * 8 + 1 + 4 + 2;
  std::vector<char> bytes(count * kStride + 1);
  const char* const first = bytes.data() + 1;
  for (std::size_t i = 0; i < count; ++i) {
    char* at = bytes.data() + 1 + i * kStride;
    const double xyz[] = {points.x[i], points.y[i], points.z[i]};
    const float time_s = static_cast<float>(points.time_ns[i]) * 1e-9F;
    std::memcpy(at, xyz, 24);
    std::memcpy(at + 25, &time_s, 4);
    std::memcpy(at + 29, &points.ring[i], 2);
  }
  PointFields fields;
  fields.x = {first, NumberType::float64, count, kStride};
  fields.y = {first + 8, NumberType::float64, count, kStride};
  fields.z = {first + 16, NumberType::float64, count, kStride};
  fields.time = {first + 25, NumberType::float32, count, kStride};
  fields.ring = {first + 29, NumberType::uint16, count, kStride};
  const LidarScan scan = ScanBuilder(*scene.model).build(fields, kStamp);
  expect_own_cells(scan, points);
  expect_own_times(scan, points, 15);  // 24 bits of 0.1 s: 7 ns, and the product's rounding
}

TEST(ScanBuilder, TimesMayHaveAnyUnit) {
  const test::ToyScene scene = room("VLP-16", 600);
  const Points points = shuffled(scene);
  const std::pair<TimeUnit, double> units[] = {{TimeUnit::seconds, 1},
                                               {TimeUnit::milliseconds, 1e3},
                                               {TimeUnit::microseconds, 1e6},
                                               {TimeUnit::nanoseconds, 1e9}};
  for (const auto& [unit, per_second] : units) {
    std::vector<double> times;
    for (const std::int64_t ns : points.time_ns) times.push_back(static_cast<double>(ns) / 1e9 * per_second);
    PointFields fields = points.fields();
    fields.time = std::span<const double>(times);
    fields.time_unit = unit;
    const LidarScan scan = ScanBuilder(*scene.model).build(fields, kStamp);
    expect_own_cells(scan, points);
    expect_own_times(scan, points, 0);
  }
}

TEST(ScanBuilder, TimesMayBeAbsolute) {
  const test::ToyScene scene = room("VLP-16", 600);
  const Points points = shuffled(scene);
  std::vector<std::int64_t> absolute = points.time_ns;
  for (std::int64_t& ns : absolute) ns += kStamp.nanoseconds();
  for (const TimeReference reference : {TimeReference::epoch, TimeReference::automatic}) {
    PointFields fields = points.fields();
    fields.time = std::span<const std::int64_t>(absolute);
    fields.time_reference = reference;
    const LidarScan scan = ScanBuilder(*scene.model).build(fields, Time());  // the stamp does not count
    expect_own_cells(scan, points);
    expect_own_times(scan, points, 0);
  }
}

// Seconds since boot, 14 hours after it: less than eleven days, so not plainly of an epoch.
TEST(ScanBuilder, TimesOnTheClockOfTheStampsAreNotAddedToTheStamp) {
  const test::ToyScene scene = room("VLP-16", 90);
  Points points = shuffled(scene);
  const std::int64_t boot_ns = 14 * 3600 * std::int64_t{1'000'000'000};
  for (std::int64_t& t : points.time_ns) t += boot_ns;
  PointFields fields = points.fields();
  fields.time_reference = TimeReference::automatic;
  const ScanBuilder builder(*scene.model);
  const LidarScan scan = builder.build(fields, Time::from_nanoseconds(boot_ns), "f");
  EXPECT_LT(std::abs((scan.start - Time::from_nanoseconds(boot_ns)).seconds()), 1.0);
  try {
    (void)builder.build(fields, Time(), "f");  // the stamps count from 0
    ADD_FAILURE() << "accepted";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("f: time"), HasSubstr("on one clock")));
  }
}

TEST(ScanBuilder, StampsNearTheEndOfTheClockAreRefused) {
  const test::ToyScene scene = room("VLP-16", 90);
  const Points points = shuffled(scene);
  const Time late = Time::from_nanoseconds(std::numeric_limits<std::int64_t>::max() - 1);
  EXPECT_THROW((void)ScanBuilder(*scene.model).build(points.fields(), late), InputError);
}

// As of a driver that stamps a scan with its last packet.
TEST(ScanBuilder, TimesBeforeTheStampAreNegative) {
  const test::ToyScene scene = room("VLP-16", 600);
  Points points = shuffled(scene);
  for (std::int64_t& ns : points.time_ns) ns -= 100'000'000;
  const LidarScan scan =
      ScanBuilder(*scene.model).build(points.fields(), kStamp + Duration::from_seconds(0.1));
  expect_own_cells(scan, points);
  expect_own_times(scan, points, 0);
}

TEST(ScanBuilder, PointsWithoutAReturnKeepTheirPlace) {
  const test::ToyScene scene = room("VLP-16", 600);
  Points points = shuffled(scene);
  std::size_t usable = 0;
  for (std::size_t i = 0; i < points.x.size(); ++i) {
    if (i % 5 == 0) points.x[i] = std::numeric_limits<float>::quiet_NaN();
    if (i % 5 == 1) points.x[i] = points.y[i] = points.z[i] = 0;
    usable += i % 5 > 1 ? 1 : 0;
  }
  const LidarScan scan = ScanBuilder(*scene.model).build(points.fields(), kStamp);
  EXPECT_EQ(scan.input_size, points.x.size());
  EXPECT_EQ(scan.returns.size(), usable);
  for (const LidarReturn& r : scan.returns) {
    ASSERT_EQ(r.position_v, points.truth[r.input_index].position_v);
    ASSERT_EQ(r.laser, points.truth[r.input_index].laser);
  }
}

TEST(ScanBuilder, NoPointsAreAScanWithoutReturns) {
  const LidarScan scan = ScanBuilder(named_model("VLP-16")).build({}, kStamp);
  EXPECT_EQ(scan.start, kStamp);
  EXPECT_EQ(scan.input_size, 0u);
  EXPECT_TRUE(scan.returns.empty());
}

TEST(ScanBuilder, AScanMayBeginAnywhereAndBeLongerThanATurn) {
  const test::ToyScene scene = room("VLP-16", 600);
  std::vector<LidarRecord> records;  // columns 250 to 899 of two turns
  for (int turn = 0; turn < 2; ++turn) {
    for (LidarRecord r : test::cast_scan(scene, turn).records) {
      r.column += 600 * turn;
      r.time_ns += 100'000'000 * turn;
      if (r.column >= 250 && r.column < 900) records.push_back(r);
    }
  }
  Points points = points_of(records);
  const LidarScan scan = ScanBuilder(*scene.model).build(points.fields(), kStamp);
  EXPECT_EQ(scan.columns, 650);
  EXPECT_NEAR(std::remainder(scan.model->hub_angle(0) - scene.model->hub_angle(250), kTurn_rad), 0, 1e-9);
  for (LidarRecord& r : points.truth) r.column -= 250;
  expect_own_cells(scan, points);
  expect_own_times(scan, points, 0);
}

TEST(ScanBuilder, AnUnknownSensorIsRecoveredFromItsPoints) {
  const test::ToyScene scene = room("VLP-16", 1800);
  const std::vector<Points> scans = {shuffled(scene, 0), shuffled(scene, 1)};
  const std::vector<Time> stamps = {kStamp, kStamp + Duration::from_seconds(0.1)};
  const std::vector<PointFields> fields = {scans[0].fields(), scans[1].fields()};
  const ScanBuilder builder = ScanBuilder::recover(fields, stamps, "drive");
  ASSERT_EQ(builder.model()->lasers.size(), 16u);
  EXPECT_EQ(builder.model()->direction, scene.model->direction);
  EXPECT_NEAR(builder.model()->rotation_rate_hz, 10, 0.05);
  EXPECT_FALSE(builder.notes().empty());
  ASSERT_TRUE(builder.estimate().has_value());
  EXPECT_EQ(builder.estimate()->scans_used, 2);
  for (std::size_t i = 0; i < 16; ++i)
    EXPECT_NEAR(builder.model()->lasers[i].elevation_rad, scene.model->lasers[i].elevation_rad, 5e-4);
  const LidarScan scan = builder.build(fields[1], stamps[1]);
  ASSERT_EQ(scan.returns.size(), scans[1].truth.size());
  const double column_rad = kTurn_rad / builder.model()->columns;
  for (const LidarReturn& r : scan.returns) {
    const auto range_m = static_cast<double>(r.range_m);
    ASSERT_EQ(r.laser, scans[1].truth[r.input_index].laser);
    const Eigen::Vector3d on_ray = scan.model->point_v(r.laser, r.column, range_m);
    ASSERT_LT((on_ray - r.position_v.cast<double>()).norm(), column_rad * range_m);
  }
}

class ScanBuilderRefuses : public testing::Test {
 protected:
  [[nodiscard]] std::string refusal() const { return refusal(points.fields()); }
  [[nodiscard]] std::string refusal(const PointFields& fields) const {
    try {
      (void)ScanBuilder(*scene.model).build(fields, kStamp, "scan 7");
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr("scan 7"));
      EXPECT_NE(error.detail().remedy, "");
      return error.what();
    }
    return "accepted";
  }
  template <class Number>
  [[nodiscard]] std::string refusal_of_times(const std::vector<Number>& times, TimeUnit unit) const {
    PointFields fields = points.fields();
    fields.time = std::span<const Number>(times);
    fields.time_unit = unit;
    return refusal(fields);
  }

  test::ToyScene scene = room("VLP-16", 600);
  Points points = shuffled(scene);
};

TEST_F(ScanBuilderRefuses, FieldsOfDifferentLengths) {
  points.ring.pop_back();
  EXPECT_THAT(refusal(), AllOf(HasSubstr("ring"), HasSubstr("not one per point")));
  PointFields fields = points.fields();
  fields.z = {};
  EXPECT_THAT(refusal(fields), AllOf(HasSubstr("z = 0 numbers"), HasSubstr("not one per point")));
}

TEST_F(ScanBuilderRefuses, RingsOfAnotherSensor) {
  points.ring[3] = 16;
  EXPECT_THAT(refusal(), AllOf(HasSubstr("point 3 ring = 16"), HasSubstr("16 lasers of VLP-16")));
}

TEST_F(ScanBuilderRefuses, RingsThatAreNotIntegers) {
  std::vector<float> rings(points.ring.begin(), points.ring.end());
  rings[2] = 1.5F;
  PointFields fields = points.fields();
  fields.ring = std::span<const float>(rings);
  EXPECT_THAT(refusal(fields), HasSubstr("point 2 ring = 1.5"));
}

TEST_F(ScanBuilderRefuses, PointsThatDoNotLieOnTheBeams) {
  for (std::uint16_t& ring : points.ring) ring = static_cast<std::uint16_t>((ring + 5) % 16);
  EXPECT_THAT(refusal(), HasSubstr("off its beams"));
}

TEST_F(ScanBuilderRefuses, TimesThatAreNotFinite) {
  std::vector<double> times(points.time_ns.size(), 0);
  times[4] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(refusal_of_times(times, TimeUnit::seconds),
              AllOf(HasSubstr("point 4 time = nan"), HasSubstr("seconds")));
}

TEST_F(ScanBuilderRefuses, TimesInAnotherUnit) {
  EXPECT_THAT(refusal_of_times(points.time_ns, TimeUnit::microseconds),  // a turn of 100 s
              AllOf(HasSubstr("time"), HasSubstr("more than three turns")));
}

TEST_F(ScanBuilderRefuses, TimesTooCoarseForAColumn) {
  std::vector<float> times;  // since the start of the computer
  for (const std::int64_t ns : points.time_ns) times.push_back(40'000 + 1e-9F * static_cast<float>(ns));
  EXPECT_THAT(refusal_of_times(times, TimeUnit::seconds), HasSubstr("cannot tell two columns apart"));
}

TEST_F(ScanBuilderRefuses, TimesThatAreAllEqual) {
  std::fill(points.time_ns.begin(), points.time_ns.end(), 0);
  EXPECT_THAT(refusal(), AllOf(HasSubstr("time = 0 ns"), HasSubstr("leave the times out")));
}

TEST_F(ScanBuilderRefuses, RowsThatDoNotDivideThePoints) {
  PointFields fields = points.fields();
  fields.rows = points.x.size() + 1;
  EXPECT_THAT(refusal(fields), HasSubstr("rows"));
}

TEST_F(ScanBuilderRefuses, ARecoveryFromNoScans) {
  EXPECT_THROW((void)ScanBuilder::recover({}, {}, "drive"), InputError);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
