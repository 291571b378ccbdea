#include <algorithm>
#include <cstdint>
#include <random>
#include <span>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/toy_scene.hpp"
#include <mapless/lidar/scan_builder.hpp>

namespace mapless {
namespace MAPLESS_FILE {

const Time kStamp = Time::from_nanoseconds(1'700'000'000'000'000'000);

struct Columns {
  std::vector<float> x, y, z;
  std::vector<std::uint16_t> ring;
  std::vector<std::int64_t> time_ns;
};

LidarScan built(const LidarModel& model, const std::vector<LidarRecord>& records, bool with_times) {
  Columns c;
  for (const LidarRecord& r : records) {
    c.x.push_back(r.position_v.x());
    c.y.push_back(r.position_v.y());
    c.z.push_back(r.position_v.z());
    c.ring.push_back(static_cast<std::uint16_t>(r.laser));
    c.time_ns.push_back(r.time_ns);
  }
  PointFields fields;
  fields.x = std::span<const float>(c.x);
  fields.y = std::span<const float>(c.y);
  fields.z = std::span<const float>(c.z);
  fields.ring = std::span<const std::uint16_t>(c.ring);
  if (with_times) fields.time = std::span<const std::int64_t>(c.time_ns);
  fields.time_unit = TimeUnit::nanoseconds;
  return ScanBuilder(model).build(fields, kStamp, "");
}

// Every third ray has a farther return, every third one its return twice, in whichever order a driver
// publishes them.
TEST(SecondReturns, OfARayTheNearestIsKept) {
  const test::ToyScene scene = with_columns(test::toy_room("VLP-16", test::drive(2, 0.3)), 600);
  std::vector<LidarRecord> single = test::cast_scan(scene, 0).records;
  std::erase_if(single, [](const LidarRecord& r) { return r.code != ReturnCode::hit; });
  std::mt19937 random(7);
  std::shuffle(single.begin(), single.end(), random);
  std::vector<LidarRecord> records = single;
  for (std::size_t i = 0; i < single.size(); ++i) {
    if (i % 3 == 2) continue;
    records.push_back(single[i]);
    if (i % 3 == 0) records.back().position_v *= 1.5f;
    if (i % 2 == 0) std::swap(records[i], records.back());
  }
  for (const bool with_times : {true, false}) {
    SCOPED_TRACE(with_times);
    const LidarScan scan = built(*scene.model, records, with_times);
    const LidarScan expected = built(*scene.model, single, with_times);
    EXPECT_EQ(scan.input_size, records.size());
    EXPECT_EQ(scan.cells, expected.cells);
    ASSERT_EQ(scan.returns.size(), single.size());
    for (std::size_t i = 0; i < scan.returns.size(); ++i)
      ASSERT_EQ(scan.returns[i].position_v, expected.returns[i].position_v) << i;
  }
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
