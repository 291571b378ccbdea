#include "lidar/recovery/model_estimation.hpp"

#include <cmath>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lidar/recovery/ring_recovery.hpp"
#include "support/bare_cloud.hpp"
#include <mapless/core/errors.hpp>

namespace mapless {
namespace MAPLESS_FILE {

using test::Cloud;
using test::make_bare_cloud;
using test::make_bare_cloud_model;

constexpr double kPi = std::numbers::pi;
constexpr double kDegree = kPi / 180;

double across(const Laser& laser) {
  return laser.origin_h_m.y() * std::cos(laser.azimuth_offset_rad) -
         laser.origin_h_m.x() * std::sin(laser.azimuth_offset_rad);
}

void expect_elevations(const LidarModel& estimated, const LidarModel& truth) {
  ASSERT_EQ(estimated.lasers.size(), truth.lasers.size());
  for (std::size_t i = 0; i < truth.lasers.size(); ++i) {
    SCOPED_TRACE(i);
    EXPECT_NEAR(estimated.lasers[i].elevation_rad, truth.lasers[i].elevation_rad, 0.005 * kDegree);
    EXPECT_NEAR(estimated.lasers[i].origin_h_m.z(), truth.lasers[i].origin_h_m.z(), 0.002);
  }
}

TEST(EstimateModel, AUniformGridGivesOffsetsModuloAColumn) {
  const LidarModel truth = make_bare_cloud_model(32, 1800);
  const EstimatedModel e =
      estimate_model({make_bare_cloud(truth, 0), make_bare_cloud(truth, 0, 1.3)}, {}, "clouds");
  expect_elevations(e.model, truth);
  EXPECT_EQ(e.model.columns, 1800);
  EXPECT_EQ(e.estimate.scans_used, 2);
  EXPECT_EQ(e.estimate.azimuths_known, 32);
  EXPECT_FALSE(e.estimate.azimuths_absolute);
  EXPECT_LT(e.estimate.elevation_residual_m, 1e-3);
  EXPECT_LT(e.estimate.azimuth_residual_columns, 0.01);
  const double step = 2 * kPi / 1800;
  for (std::size_t i = 0; i < truth.lasers.size(); ++i) {
    SCOPED_TRACE(i);
    const double off = e.model.lasers[i].azimuth_offset_rad - truth.lasers[i].azimuth_offset_rad;
    EXPECT_NEAR(std::remainder(off, step), 0, 0.01 * step);
    EXPECT_LE(std::abs(e.model.lasers[i].azimuth_offset_rad), 0.51 * step);
    EXPECT_NEAR(across(e.model.lasers[i]), across(truth.lasers[i]), 5e-4);
  }
}

TEST(EstimateModel, AnIrregularEncoderGivesCompleteOffsets) {
  const LidarModel truth = make_bare_cloud_model(64, 2152);
  const EstimatedModel e =
      estimate_model({make_bare_cloud(truth, 4000), make_bare_cloud(truth, 4000, 1.3)}, {}, "clouds");
  expect_elevations(e.model, truth);
  EXPECT_EQ(e.layout.encoder_steps, 4000);
  EXPECT_TRUE(e.estimate.azimuths_absolute);
  EXPECT_EQ(e.estimate.azimuths_known, 64);
  EXPECT_GE(e.model.columns, 2152);
  EXPECT_LE(e.model.columns, 2156);
  const double common = e.model.lasers[0].azimuth_offset_rad - truth.lasers[0].azimuth_offset_rad;
  // The true ones are centred on 0 already.
  EXPECT_LT(std::abs(common), 0.1 * kDegree);
  for (std::size_t i = 0; i < truth.lasers.size(); ++i) {
    SCOPED_TRACE(i);
    EXPECT_NEAR(e.model.lasers[i].azimuth_offset_rad - truth.lasers[i].azimuth_offset_rad, common,
                0.003 * kDegree);
    EXPECT_NEAR(across(e.model.lasers[i]), across(truth.lasers[i]), 5e-4);
  }
}

TEST(EstimateModel, EstimatedBeamsPassThroughThePoints) {
  const LidarModel truth = make_bare_cloud_model(16, 1000);
  const Cloud cloud = make_bare_cloud(truth, 0);
  const EstimatedModel e = estimate_model({cloud}, {}, "cloud");
  const auto records = recover_records(cloud, e.model, e.layout, Duration::from_seconds(0.1), "cloud");
  for (const LidarRecord& r : records) {
    const Eigen::Vector3d p = r.position_v.cast<double>();
    const Eigen::Vector3d origin = rotation_z(e.model.hub_angle(r.column)) *
                                   e.model.lasers[static_cast<std::size_t>(r.laser)].origin_h_m;
    const Eigen::Vector3d on_beam = e.model.point_v(r.laser, r.column, (p - origin).norm());
    ASSERT_LT((on_beam - p).norm(), 2e-4 * p.norm());
  }
}

TEST(EstimateModel, ARingAtOneDistanceTakesItsOriginFromItsNeighbours) {
  const LidarModel truth = make_bare_cloud_model(16, 1000);
  Cloud cloud = make_bare_cloud(truth, 0);
  // The fourth stored ring (row 12) sees a round wall.
  const Laser& laser = truth.lasers[12];
  for (std::size_t i = 3000; i < 4000; ++i) {
    const double azimuth = 2 * kPi * (static_cast<double>(i) - 2999.5) / 1000;
    cloud[i] = Eigen::Vector3d(10 * std::cos(azimuth), 10 * std::sin(azimuth),
                               0.2 + 10 * std::tan(laser.elevation_rad))
                   .cast<float>();
  }
  const EstimatedModel e = estimate_model({cloud}, {}, "cloud");
  EXPECT_EQ(e.estimate.lasers_borrowed, 1);
  EXPECT_NEAR(e.model.lasers[12].origin_h_m.z(), 0.2, 1e-3);
  EXPECT_NEAR(e.model.lasers[12].elevation_rad, laser.elevation_rad, 0.01 * kDegree);
}

TEST(EstimateModel, StrayPointsDoNotMoveTheLines) {
  const LidarModel truth = make_bare_cloud_model(16, 1000);
  Cloud cloud = make_bare_cloud(truth, 0);
  for (std::size_t i = 0; i < cloud.size(); i += 20) cloud[i].z() += 1.0F;
  expect_elevations(estimate_model({cloud}, {}, "cloud").model, truth);
}

TEST(EstimateModel, ScansWithTheExpectedRingsAreUsed) {
  const LidarModel truth = make_bare_cloud_model(16, 1000);
  const Cloud whole = make_bare_cloud(truth, 0);
  const Cloud without_top(whole.begin() + 1000, whole.end());
  ModelEstimationOptions options;
  options.expected_rings = 16;
  const EstimatedModel e = estimate_model({without_top, whole, without_top}, options, "clouds");
  EXPECT_EQ(e.estimate.scans_used, 1);
  EXPECT_EQ(e.model.lasers.size(), 16U);
}

TEST(EstimateModel, RandomAzimuthsHaveNoGrid) {
  const LidarModel truth = make_bare_cloud_model(16, 1000);
  Cloud cloud = make_bare_cloud(truth, 0);
  std::mt19937 random(7);
  std::uniform_real_distribution<float> turn(-0.003F, 0.003F);
  for (Eigen::Vector3f& p : cloud) {
    const float a = turn(random);
    p = Eigen::Vector3f(p.x() - a * p.y(), p.y() + a * p.x(), p.z());
  }
  const EstimatedModel e = estimate_model({cloud}, {}, "cloud");
  EXPECT_EQ(e.estimate.encoder_steps, 0);
  EXPECT_EQ(e.estimate.azimuths_known, 0);
  for (const Laser& laser : e.model.lasers) EXPECT_EQ(laser.azimuth_offset_rad, 0);
}

// 40 rings, the points in an order in which the azimuth drops at every third point or so.
TEST(EstimateModel, RefusesPointsInAnotherOrder) {
  Cloud cloud = make_bare_cloud(make_bare_cloud_model(40, 900), 0);
  const std::size_t stride = 7919;  // a prime, so that every point comes once
  ASSERT_NE(cloud.size() % stride, 0u);
  Cloud shuffled(cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) shuffled[i] = cloud[i * stride % cloud.size()];
  try {
    (void)estimate_model({shuffled}, {}, "cloud");
    ADD_FAILURE() << "no error";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("not stored ring after ring"));
  }
}

// Neighbours of one ring are given sixteen rings: metres from any beam.
TEST(EstimateModel, RefusesRingsThatPointsDoNotLieOn) {
  const LidarModel truth = make_bare_cloud_model(16, 1000);
  RingedCloud cloud{make_bare_cloud(truth, 0), {}};
  for (std::size_t i = 0; i < cloud.points.size(); ++i)
    cloud.rings.push_back(static_cast<std::int32_t>(i % 16));  // stored ring after ring
  try {
    (void)estimate_model_of_rings({cloud}, 16, {}, "cloud");
    ADD_FAILURE() << "no error";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("so far from 16 beams"));
  }
}

TEST(EstimateModel, RefusesCloudsWithoutPoints) {
  EXPECT_THROW((void)estimate_model({}, {}, "nothing"), InputError);
  EXPECT_THROW((void)estimate_model({{}, {{0, 0, 0}}}, {}, "nothing"), InputError);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
