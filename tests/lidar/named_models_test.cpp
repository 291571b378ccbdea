#include <cmath>
#include <fstream>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "support/paths.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/lidar/lidar_model.hpp>

namespace mapless {
namespace MAPLESS_FILE {

constexpr double kDegree = std::numbers::pi / 180;

struct Expected {
  const char* name;
  std::size_t lasers;
  double lowest_deg, highest_deg, largest_offset_deg, max_range_m;
  double column_us;  // at 10 Hz
};

// Method.md section 5, and the vendors' sheets for the ranges.
const std::vector<Expected> kExpected = {
    {"HDL-64E-S2", 64, -24.85, 4.97, 9.6, 120, 48.0}, {"HDL-64E-S3", 64, -24.56, 1.96, 9.9, 120, 57.6},
    {"VLP-16", 16, -15, 15, 0.13, 100, 55.296},       {"HDL-32E", 32, -30.67, 10.67, 0.13, 100, 46.08},
    {"OS1-64", 64, -16.68, 16.73, 3.4, 120, 97.656},  {"OS1-128", 128, -21.48, 21.48, 4.26, 120, 97.656},
    {"Pandar64", 64, -24.88, 14.9, 5.4, 200, 55.56},  {"XT-32", 32, -16.02, 14.97, 0.114, 120, 50}};

TEST(NamedModels, HaveTheAnglesTimesAndRangesOfTheirDataSheets) {
  ASSERT_EQ(named_models().size(), kExpected.size());
  for (const Expected& e : kExpected) {
    SCOPED_TRACE(e.name);
    const LidarModel model = named_model(e.name);
    EXPECT_NO_THROW(validate(model, e.name));
    EXPECT_EQ(model.name, e.name);
    ASSERT_EQ(model.lasers.size(), e.lasers);
    EXPECT_NEAR(model.lasers.front().elevation_rad / kDegree, e.lowest_deg, 0.006);
    EXPECT_NEAR(model.lasers.back().elevation_rad / kDegree, e.highest_deg, 0.006);
    double largest = 0;
    for (const Laser& laser : model.lasers) largest = std::max(largest, std::abs(laser.azimuth_offset_rad));
    EXPECT_NEAR(largest / kDegree, e.largest_offset_deg, 0.05);
    EXPECT_EQ(model.max_range_m, e.max_range_m);
    EXPECT_NEAR(1e6 / (model.rotation_rate_hz * model.columns), e.column_us, 0.02);
    EXPECT_EQ(model.direction, SpinDirection::clockwise);
  }
}

TEST(NamedModels, NamesIgnoreCaseAndUnknownOnesListTheKnown) {
  EXPECT_EQ(named_model("vlp-16").name, "VLP-16");
  try {
    (void)named_model("VLP-17");
    FAIL();
  } catch (const ParameterError& error) {
    EXPECT_THAT(error.what(), ::testing::HasSubstr("VLP-17"));
    for (const std::string& name : named_models()) EXPECT_THAT(error.what(), ::testing::HasSubstr(name));
  }
}

TEST(NamedModels, BlocksOfTheHdl64eS2OverlapInElevation) {
  for (const Laser& laser : named_model("HDL-64E-S2").lasers) {
    // The beam's offset at a right angle to it: 0.026 m to a side; upwards .19 to .21 (upper block), .10 to
    // .13 (lower).
    const Eigen::Vector3d offset = laser.T_lh().rotation() * laser.origin_h_m;
    EXPECT_NEAR(offset.x(), 0, 1e-12);
    EXPECT_NEAR(std::abs(offset.y()), 0.026, 1e-9);
    EXPECT_TRUE((offset.z() > 0.10 && offset.z() < 0.13) || (offset.z() > 0.19 && offset.z() < 0.22))
        << offset.z();
  }
}

// A VLP-16 fires -15, 1, -13, 3 ... degrees, 2.304 us apart, while the hub turns clockwise.
TEST(NamedModels, AzimuthOffsetIncludesTheRotationDuringFiring) {
  const LidarModel model = named_model("VLP-16");
  const auto laser_at = [&](double elevation_deg) {
    for (const Laser& l : model.lasers) {
      if (std::abs(l.elevation_rad - elevation_deg * kDegree) < 1e-9) return l;
    }
    throw std::runtime_error("no such laser");
  };
  EXPECT_EQ(laser_at(-15).firing_offset.nanoseconds(), 0);
  EXPECT_EQ(laser_at(1).firing_offset.nanoseconds(), 2304);
  EXPECT_EQ(laser_at(-13).firing_offset.nanoseconds(), 4608);
  EXPECT_EQ(laser_at(15).firing_offset.nanoseconds(), 34560);
  EXPECT_NEAR(laser_at(15).azimuth_offset_rad, -3600 * kDegree * 34.56e-6, 1e-12);
  EXPECT_EQ(laser_at(-15).azimuth_offset_rad, 0);
}

// The formula of Ouster's manual, in millimetres, from the sensor's own metadata, then into its "sensor"
// frame.
TEST(NamedModels, OusterRaysAgreeWithItsMetadata) {
  const std::vector<std::pair<const char*, const char*>> cases = {
      {"OS1-64", "calib/ouster_json/2_1_2_os1-991913000010-64_legacy.json"},
      {"OS1-128", "calib/ouster_json/2_0_0_os1-992008000494-128_col_win_legacy.json"}};
  for (const auto& [name, file] : cases) {
    SCOPED_TRACE(name);
    MAPLESS_SKIP_WITHOUT(test::shared_data(file));
    const auto metadata = nlohmann::json::parse(std::ifstream(test::shared_data(file)));
    const double n = metadata["lidar_origin_to_beam_origin_mm"];
    const double z = metadata["lidar_to_sensor_transform"][11];
    const LidarModel model = named_model(name);
    const std::size_t count = model.lasers.size();
    for (std::size_t row = 0; row < count; ++row) {
      for (const int column : {0, 100, 777}) {
        const double r = 30'000;
        const double encoder = 2 * std::numbers::pi * (1 - column / 1024.0);
        const double azimuth = -metadata["beam_azimuth_angles"][count - 1 - row].get<double>() * kDegree;
        const double altitude = metadata["beam_altitude_angles"][count - 1 - row].get<double>() * kDegree;
        const Eigen::Vector3d lidar(
            (r - n) * std::cos(encoder + azimuth) * std::cos(altitude) + n * std::cos(encoder),
            (r - n) * std::sin(encoder + azimuth) * std::cos(altitude) + n * std::sin(encoder),
            (r - n) * std::sin(altitude));
        const Eigen::Vector3d sensor = Eigen::Vector3d(-lidar.x(), -lidar.y(), lidar.z() + z) / 1000;
        EXPECT_LT((model.point_v(static_cast<int>(row), column, (r - n) / 1000) - sensor).norm(), 1e-9);
      }
    }
  }
}

// Hesai measures azimuths clockwise from y, and adds each channel's own and the turn until it fires.
TEST(NamedModels, HesaiRaysAgreeWithItsAngleFiles) {
  const LidarModel model = named_model("XT-32");
  const double fired = 6e-6 + 31 * 1.512e-6;  // channel 32, the lowest
  const double azimuth = 40 * kDegree + (-0.129679 + 3600 * fired) * kDegree;
  const Eigen::Vector3d along(std::sin(azimuth), std::cos(azimuth), 0);
  const double turned = 40 * kDegree + 3600 * fired * kDegree;
  const Eigen::Vector3d forward(std::sin(turned), std::cos(turned), 0),
      right(std::cos(turned), -std::sin(turned), 0);
  const double el = -16.023602 * kDegree;
  const Eigen::Vector3d expected = -0.013 * right + 0.032 * forward +
                                   50 * (std::cos(el) * along + std::sin(el) * Eigen::Vector3d::UnitZ());
  EXPECT_LT((model.point_v(0, 40 / 0.18, 50) - expected).norm(), 1e-6);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
