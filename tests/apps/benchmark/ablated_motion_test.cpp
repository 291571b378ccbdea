#include "benchmark/ablated_motion.hpp"

#include <memory>

#include <gtest/gtest.h>

#include <mapless/geometry/compensated_scan.hpp>

namespace mapless::app {
namespace MAPLESS_FILE {

using Eigen::Vector3d;

// 10 m/s along x, from the origin at time 0.
SampledTrajectory moving() {
  const auto pose = [](double t) {
    return TimedPose{Time::from_nanoseconds(static_cast<std::int64_t>(t * 1e9)),
                     SE3(Eigen::Matrix3d::Identity(), Vector3d(10 * t, 0, 0)).inverse()};
  };
  return {{pose(-1), pose(2)}, Duration(), "test"};
}

// A hit 5 m ahead at the begin, in the middle and near the end of the turn.
std::shared_ptr<const LidarScan> scan() {
  LidarScan out;
  auto model = std::make_shared<LidarModel>(named_model("VLP-16"));
  out.columns = 100;
  out.column_period = Duration::from_nanoseconds(1'000'000);
  out.model = std::move(model);
  for (const int column : {0, 50, 99})
    out.returns.push_back({{5, 0, 0}, 5, column * 1'000'000, column, 0, static_cast<std::uint32_t>(column)});
  return std::make_shared<const LidarScan>(std::move(out));
}

struct InWorld {
  double first_x, middle_x, last_x;              // of the points
  double first_ray_x, middle_ray_x, last_ray_x;  // where the sensor stands
};

InWorld in_world(Compensation compensation) {
  const DetectorInput input =
      ablate_motion(scan(), std::make_shared<const SampledTrajectory>(moving()), compensation);
  const CompensatedScan c = compensate(input.scan, *input.trajectory);
  const auto sensor_x = [&](std::size_t column) { return c.column_T_0v[column].translation().x(); };
  return {c.points_0[0].x(), c.points_0[1].x(), c.points_0[2].x(), sensor_x(0), sensor_x(50), sensor_x(99)};
}

void expect_points(const InWorld& w, bool compensated) {
  EXPECT_NEAR(w.first_x, compensated ? 5 : 5.5, 1e-5);
  EXPECT_NEAR(w.middle_x, 5.5, 1e-5);
  EXPECT_NEAR(w.last_x, compensated ? 5.99 : 5.5, 1e-5);
}

void expect_rays(const InWorld& w, bool compensated) {
  EXPECT_NEAR(w.first_ray_x, compensated ? 0 : 0.5, 1e-5);
  EXPECT_NEAR(w.middle_ray_x, 0.5, 1e-5);
  EXPECT_NEAR(w.last_ray_x, compensated ? 0.99 : 0.5, 1e-5);
}

TEST(AblatedMotion, EachAblationTakesPointsOrRaysFromTheMiddleOfTheScan) {
  const InWorld full = in_world(Compensation::full);
  expect_points(full, true);
  expect_rays(full, true);
  const InWorld not_of_clouds = in_world(Compensation::not_of_clouds);
  expect_points(not_of_clouds, false);
  expect_rays(not_of_clouds, true);
  const InWorld not_of_rays = in_world(Compensation::not_of_rays);
  expect_points(not_of_rays, true);
  expect_rays(not_of_rays, false);
  const InWorld none = in_world(Compensation::none);
  expect_points(none, false);
  expect_rays(none, false);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless::app
