#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/LU>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <mapless/core/errors.hpp>
#include <mapless/lidar/lidar_model.hpp>

namespace mapless {
namespace MAPLESS_FILE {

constexpr double kDegree = std::numbers::pi / 180;

Laser tilted_laser() {
  Laser laser;
  laser.elevation_rad = -0.3;
  laser.azimuth_offset_rad = 0.7;
  laser.origin_h_m = {0.02, -0.03, 0.2};
  return laser;
}

LidarModel small_model() {
  LidarModel model;
  model.columns = 360;
  model.start_azimuth_rad = std::numbers::pi;
  model.min_range_m = 0.5;
  model.max_range_m = 100;
  model.lasers = {tilted_laser(), tilted_laser(), tilted_laser()};
  model.lasers[1].elevation_rad = -0.1;
  model.lasers[2].elevation_rad = 0.15;
  return model;
}

std::string refusal(const LidarModel& model) {
  try {
    validate(model, "sensor.yaml");
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(Laser, DirectionHasItsElevationAndAzimuth) {
  const Eigen::Vector3d d = tilted_laser().direction_h();
  EXPECT_NEAR(d.norm(), 1, 1e-15);
  EXPECT_NEAR(std::asin(d.z()), -0.3, 1e-15);
  EXPECT_NEAR(std::atan2(d.y(), d.x()), 0.7, 1e-15);
}

TEST(Laser, LaserFrameHasXAlongTheBeamAndYHorizontal) {
  const Laser laser = tilted_laser();
  const SE3 T_lh = laser.T_lh();
  EXPECT_LT((T_lh * laser.origin_h_m).norm(), 1e-15);
  const Eigen::Vector3d on_beam = laser.origin_h_m + 12 * laser.direction_h();
  EXPECT_LT((T_lh * on_beam - Eigen::Vector3d(12, 0, 0)).norm(), 1e-14);
  const Eigen::Vector3d y_h = T_lh.rotation().transpose() * Eigen::Vector3d::UnitY();
  EXPECT_EQ(y_h.z(), 0);
  // To the left of the beam: where the azimuth grows.
  EXPECT_GT((T_lh * (on_beam + Eigen::Vector3d(-std::sin(0.7), std::cos(0.7), 0))).y(), 0.99);
  EXPECT_NEAR(T_lh.rotation().determinant(), 1, 1e-15);
  EXPECT_LT((T_lh.rotation() * T_lh.rotation().transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-15);
}

TEST(LidarModel, HubAngleFollowsTheDirectionOfRotation) {
  LidarModel model = small_model();
  EXPECT_NEAR(model.hub_angle(0), std::numbers::pi, 1e-15);
  EXPECT_NEAR(model.hub_angle(90), std::numbers::pi / 2, 1e-15);
  model.direction = SpinDirection::counter_clockwise;
  EXPECT_NEAR(model.hub_angle(0.5), std::numbers::pi + 0.5 * kDegree, 1e-15);
}

TEST(LidarModel, PointAgreesWithTheFormulaOfTheNativeFormat) {
  const LidarModel model = small_model();
  // At column 90 the clockwise hub, which began at the rear, points to the left: hub x is sensor y.
  const double el = -0.1, az = 0.7, range = 20;
  const double hx = 0.02 + range * std::cos(el) * std::cos(az);
  const double hy = -0.03 + range * std::cos(el) * std::sin(az);
  const Eigen::Vector3d expected(-hy, hx, 0.2 + range * std::sin(el));
  EXPECT_LT((model.point_v(1, 90, range) - expected).norm(), 1e-13);
}

TEST(LidarModel, ElevationStepIsThatToTheFartherNeighbour) {
  LidarModel model = small_model();
  model.lasers.resize(1);
  EXPECT_EQ(model.elevation_step(0), 0);
  EXPECT_EQ(model.mean_elevation_step(), 0);
  model.lasers.resize(3, model.lasers[0]);
  model.lasers[1].elevation_rad = model.lasers[0].elevation_rad + 0.1;
  model.lasers[2].elevation_rad = model.lasers[1].elevation_rad + 0.3;
  EXPECT_NEAR(model.elevation_step(0), 0.1, 1e-15);
  EXPECT_NEAR(model.elevation_step(1), 0.3, 1e-15);
  EXPECT_NEAR(model.mean_elevation_step(), 0.2, 1e-15);
  EXPECT_NEAR(model.elevation_step(2), 0.3, 1e-15);
}

TEST(LidarModel, LargestElevationStep) {
  LidarModel model = small_model();
  EXPECT_NEAR(model.largest_elevation_step(), 0.25, 1e-15);
  model.lasers.resize(1);
  EXPECT_EQ(model.largest_elevation_step(), 0);
}

TEST(LidarModel, ValidationNamesTheInvalidMember) {
  using ::testing::AllOf;
  using ::testing::HasSubstr;
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  EXPECT_EQ(refusal(small_model()), "accepted");
  const auto broken = [](auto change) {
    LidarModel model = small_model();
    change(model);
    return refusal(model);
  };
  EXPECT_THAT(broken([](LidarModel& m) { m.lasers.clear(); }),
              AllOf(HasSubstr("sensor.yaml"), HasSubstr("lasers")));
  EXPECT_THAT(broken([](LidarModel& m) { m.columns = 0; }), HasSubstr("columns = 0"));
  EXPECT_THAT(broken([](LidarModel& m) { m.rotation_rate_hz = -10; }), HasSubstr("rate_hz = -10"));
  EXPECT_THAT(broken([&](LidarModel& m) { m.rotation_rate_hz = inf; }), HasSubstr("rate_hz = inf"));
  // 10 Hz as turns a minute; with times that are called nanoseconds and are microseconds, or seconds and
  // milliseconds.
  for (const double other_unit : {600.0, 10'000.0, 0.01})
    EXPECT_THAT(broken([=](LidarModel& m) { m.rotation_rate_hz = other_unit; }),
                HasSubstr("times in another unit"));
  EXPECT_THAT(broken([](LidarModel& m) { m.min_range_m = 100; }), HasSubstr("min_range_m = 100"));
  EXPECT_THAT(broken([](LidarModel& m) { m.min_range_m = -1; }), HasSubstr("min_range_m = -1"));
  EXPECT_THAT(broken([&](LidarModel& m) { m.max_range_m = nan; }), HasSubstr("max_range_m = nan"));
  EXPECT_THAT(broken([&](LidarModel& m) { m.start_azimuth_rad = nan; }), HasSubstr("start_azimuth = nan"));
  EXPECT_THAT(broken([&](LidarModel& m) { m.lasers[1].elevation_rad = nan; }),
              HasSubstr("laser 1 elevation = nan"));
  EXPECT_THAT(broken([&](LidarModel& m) { m.lasers[2].origin_h_m.y() = inf; }),
              HasSubstr("laser 2 origin = inf"));
  EXPECT_THAT(broken([&](LidarModel& m) { m.lasers[0].azimuth_offset_rad = nan; }),
              HasSubstr("azimuth offset = nan"));
  EXPECT_THAT(broken([](LidarModel& m) { m.lasers[0].azimuth_offset_rad = 1e300; }),
              AllOf(HasSubstr("laser 0 azimuth offset"), HasSubstr("-720 to 720 degrees")));
  EXPECT_THAT(broken([](LidarModel& m) { m.start_azimuth_rad = 1e17; }), HasSubstr("start_azimuth"));
  EXPECT_THAT(broken([](LidarModel& m) { m.lasers[1].origin_h_m.z() = 50; }), HasSubstr("laser 1 origin"));
  EXPECT_THAT(broken([](LidarModel& m) { m.lasers[1].firing_offset = Duration::from_seconds(0.2); }),
              AllOf(HasSubstr("laser 1 firing offset = 0.2 s"), HasSubstr("a turn of 0.1 s")));
  EXPECT_THAT(broken([](LidarModel& m) {
                m.columns = 1'000'000;
                m.lasers.resize(101);
              }),
              HasSubstr("columns x lasers = 1000000 x 101"));
  EXPECT_THAT(broken([](LidarModel& m) { m.lasers[2].elevation_rad = 2; }),
              HasSubstr("laser 2 elevation = 2 rad"));
  EXPECT_THAT(broken([](LidarModel& m) { m.lasers[2].elevation_rad = -0.2; }),
              HasSubstr("increasing elevation"));
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
