#include "io/point_oddities.hpp"

#include <functional>
#include <memory>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace mapless {
namespace MAPLESS_FILE {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr std::int32_t kPeriodNs = 55'000;

// A turn of a VLP-16 in a round room of 20 m, each record changed by `spoil`.
LidarScan turn(const std::function<void(LidarRecord&)>& spoil) {
  LidarScan scan;
  scan.model = std::make_shared<const LidarModel>(named_model("VLP-16"));
  scan.columns = scan.model->columns;
  scan.column_period = Duration::from_nanoseconds(kPeriodNs);
  scan.time_source = Provenance::sensor;
  std::vector<LidarRecord> records;
  for (int column = 0; column < scan.columns; ++column) {
    for (int laser = 0; laser < 16; ++laser) {
      records.push_back({scan.model->point_v(laser, column, 20).cast<float>(), laser, column,
                         kPeriodNs * column, ReturnCode::hit});
      spoil(records.back());
    }
  }
  return organise(std::move(scan), records, "test");
}

std::vector<std::string> oddities_of(const std::function<void(LidarRecord&)>& spoil) {
  PointOddities oddities;
  for (const std::size_t k : {std::size_t{4}, std::size_t{5}}) oddities.add(turn(spoil), k);
  return oddities.lines();
}

TEST(PointOddities, FindsNoneInPlausiblePoints) {
  EXPECT_THAT(oddities_of([](LidarRecord&) {}), IsEmpty());
}

TEST(PointOddities, FindsRangesInCentimetres) {
  EXPECT_THAT(oddities_of([](LidarRecord& r) { r.position_v *= 100; }),
              ElementsAre(AllOf(HasSubstr("scan 4 (and 1 others)"), HasSubstr("2000 m"), HasSubstr("unit"))));
}

TEST(PointOddities, FindsTimesInMicroseconds) {
  EXPECT_THAT(oddities_of([](LidarRecord& r) { r.time_ns /= 1000; }),
              ElementsAre(AllOf(HasSubstr("times of the points"), HasSubstr("unit"))));
}

TEST(PointOddities, FindsTheWrongDirectionOfRotation) {
  EXPECT_THAT(oddities_of([](LidarRecord& r) { r.position_v.y() *= -1; }),
              ElementsAre(AllOf(HasSubstr("off the beams of VLP-16"), HasSubstr("direction"))));
}

// A compensated point has left its beam.
TEST(PointOddities, DoesNotCheckTheBeamsOfCompensatedPoints) {
  LidarScan scan = turn([](LidarRecord& r) { r.position_v.y() *= -1; });
  scan.compensated_to = scan.start;
  PointOddities oddities;
  oddities.add(scan, 0);
  EXPECT_THAT(oddities.lines(), IsEmpty());
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
