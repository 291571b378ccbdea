#include "lidar/self_check/scan_checks.hpp"

#include <functional>
#include <memory>
#include <numbers>
#include <random>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lidar/self_check/time_check.hpp"

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

std::vector<std::string> lines_of(const LidarScan& scan) {
  ScanChecks checks;
  for (const std::size_t k : {std::size_t{4}, std::size_t{5}}) checks.add(scan, k, {});
  return checks.lines();
}

std::vector<std::string> oddities_of(const std::function<void(LidarRecord&)>& spoil) {
  return lines_of(turn(spoil));
}

// The same turn, said to be of a model changed by `spoil`.
std::vector<std::string> lines_of_model(const std::function<void(LidarModel&)>& spoil) {
  LidarScan scan = turn([](LidarRecord&) {});
  LidarModel model = *scan.model;
  spoil(model);
  scan.model = std::make_shared<const LidarModel>(model);
  return lines_of(scan);
}

double radians(double degrees) { return degrees * std::numbers::pi / 180; }

TEST(ScanChecks, FindsNoneInPlausiblePoints) {
  EXPECT_THAT(oddities_of([](LidarRecord&) {}), IsEmpty());
}

TEST(ScanChecks, FindsRangesInCentimetres) {
  EXPECT_THAT(oddities_of([](LidarRecord& r) { r.position_v *= 100; }),
              ElementsAre(AllOf(HasSubstr("scan 4 (and 1 others)"), HasSubstr("farther than the 100 m"),
                                HasSubstr("centimetres"))));
}

TEST(ScanChecks, FindsTimesInMicroseconds) {
  EXPECT_THAT(oddities_of([](LidarRecord& r) { r.time_ns /= 1000; }),
              ElementsAre(AllOf(HasSubstr("times of the points"), HasSubstr("look like microseconds"))));
}

TEST(ScanChecks, FindsTheWrongDirectionOfRotation) {
  EXPECT_THAT(oddities_of([](LidarRecord& r) { r.position_v.y() *= -1; }),
              ElementsAre(AllOf(HasSubstr("off the beams of VLP-16"),
                                HasSubstr("the columns run counter-clockwise"))));
}

TEST(ScanChecks, FindsTimesThatRunBackwards) {
  EXPECT_THAT(oddities_of([](LidarRecord& r) { r.time_ns = 100'000'000 - r.time_ns; }),
              ElementsAre(HasSubstr("run backwards")));
}

TEST(ScanChecks, FindsOneTimeForAllPoints) {
  EXPECT_THAT(oddities_of([](LidarRecord& r) { r.time_ns = 0; }), ElementsAre(HasSubstr("about one time")));
}

TEST(ScanChecks, FindsTheWrongRate) {
  EXPECT_THAT(oddities_of([](LidarRecord& r) { r.time_ns *= 2; }), ElementsAre(HasSubstr("rate_hz")));
}

// Sensors of 5 to 20 Hz whose times are ten times too long or too short.
TEST(ScanChecks, DoubtsRatesOfNoSpinningLidar) {
  LidarModel model = named_model("VLP-16");
  for (const auto& [rate_hz, trust] : {std::pair(5.0, Trust::right), std::pair(10.0, Trust::right),
                                       std::pair(25.0, Trust::right), std::pair(2.0, Trust::doubtful),
                                       std::pair(1.0, Trust::doubtful), std::pair(100.0, Trust::doubtful)}) {
    model.rotation_rate_hz = rate_hz;
    EXPECT_EQ(check_rate(model).trust, trust) << rate_hz << " Hz";
  }
  EXPECT_THAT(check_rate(model).problem, HasSubstr("ten times too short"));
}

// Along its beam: the noise is that of the range.
void move_along(LidarRecord& record, double by_m) {
  record.position_v += static_cast<float>(by_m) * record.position_v.normalized();
}

TEST(ScanChecks, FindsRangesWithNoise) {
  std::mt19937 random(1);
  std::normal_distribution<double> fine(0, 0.03), coarse(0, 0.3);
  EXPECT_THAT(oddities_of([&](LidarRecord& r) { move_along(r, fine(random)); }), IsEmpty());
  EXPECT_THAT(oddities_of([&](LidarRecord& r) { move_along(r, coarse(random)); }),
              ElementsAre(HasSubstr("noise of 0.30 m")));
}

TEST(ScanChecks, FindsRangesAtRandom) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> share(0, 1), off(2, 60);
  const auto spoil = [&](double part) {
    return [&random, &share, &off, part](LidarRecord& r) {
      if (share(random) < part) move_along(r, off(random));
    };
  };
  EXPECT_THAT(oddities_of(spoil(0.05)), IsEmpty());
  EXPECT_THAT(oddities_of(spoil(0.3)), ElementsAre(HasSubstr("ranges at random")));
}

TEST(ScanChecks, FindsAxesThatAreExchanged) {
  EXPECT_THAT(oddities_of([](LidarRecord& r) { std::swap(r.position_v.x(), r.position_v.y()); }),
              ElementsAre(HasSubstr("x and y of the points look swapped")));
  EXPECT_THAT(oddities_of([](LidarRecord& r) { r.position_v.z() *= -1; }),
              ElementsAre(AllOf(HasSubstr("z of the points look negated"), HasSubstr("upside down"))));
  EXPECT_THAT(oddities_of([](LidarRecord& r) {
                r.position_v = Eigen::Vector3f(-r.position_v.y(), r.position_v.x(), r.position_v.z());
              }),
              ElementsAre(HasSubstr("turned by 90.0 degrees about z")));
}

TEST(ScanChecks, FindsWhatTheSensorIsSaidToBe) {
  EXPECT_THAT(lines_of_model([](LidarModel& m) { m.start_azimuth_rad += radians(90); }),
              ElementsAre(HasSubstr("turned by -90.0 degrees")));
  EXPECT_THAT(lines_of_model([](LidarModel& m) { m.lasers[5].azimuth_offset_rad += radians(10); }),
              ElementsAre(HasSubstr("azimuth_offset_deg of laser 5 is ")));
  EXPECT_THAT(lines_of_model([](LidarModel& m) {
                for (Laser& l : m.lasers) l.elevation_rad /= 2;
              }),
              ElementsAre(HasSubstr("elevations of the points are 2.00 times")));
  EXPECT_THAT(lines_of_model([](LidarModel& m) {
                for (Laser& l : m.lasers) l.elevation_rad -= radians(3);
              }),
              ElementsAre(HasSubstr("all points are 3.0 degrees above")));
  EXPECT_THAT(lines_of_model([](LidarModel& m) { m.max_range_m = 5; }),
              ElementsAre(HasSubstr("max_range_m is too small")));
}

// A tenth of a degree is what two sensors of one type differ by.
TEST(ScanChecks, AcceptsTheCalibrationOfAnotherSensorOfTheType) {
  EXPECT_THAT(lines_of_model([](LidarModel& m) {
                for (Laser& l : m.lasers) l.elevation_rad += radians(0.1);
              }),
              IsEmpty());
}

// A compensated point has left its beam.
TEST(ScanChecks, DoesNotCheckTheBeamsOfCompensatedPoints) {
  LidarScan scan = turn([](LidarRecord& r) { r.position_v.y() *= -1; });
  scan.compensated_to = scan.start;
  EXPECT_THAT(lines_of(scan), IsEmpty());
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
