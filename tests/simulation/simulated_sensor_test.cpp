#include <cmath>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "support/cast_rays.hpp"
#include "support/toy_scene.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/labels.hpp>
#include <mapless/simulation/scene.hpp>

namespace mapless {
namespace MAPLESS_FILE {

using Eigen::Vector3d;

/// A closed room 40 x 40 x 20 m and a cube in it that slides along y, 8 m ahead.
WorldDescription room(double cube_speed, Material walls) {
  WorldDescription world;
  world.shapes.resize(2);
  world.shapes[0].add_box({-20, -20, -10}, {20, 20, 10}, walls);
  world.shapes[1].add_box({-1, -1, -1}, {1, 1, 1}, Material::cloth);
  world.statics.push_back({0, SE3(), ObjectClass::building, 0});
  Mover cube;
  cube.object_id = 5;
  cube.T_0b = [cube_speed](Time t) {
    return SE3(Eigen::Matrix3d::Identity(), {8, cube_speed * t.seconds(), 0});
  };
  cube.parts.push_back({1, nullptr});
  world.movers.push_back(std::move(cube));
  return world;
}

SensorOptions exact() {
  SensorOptions options;
  options.range_noise_m = 0;
  options.faulty = false;
  return options;
}

SimulatedScan first_scan(const WorldDescription& description, const SensorOptions& options, int number = 0) {
  SimulatedWorld world(description);
  SimulatedSensor sensor(test::awkward_model(16, 360), test::drive(3, 0.5), world, options);
  return sensor.scan(number);
}

TEST(SimulatedSensor, PointsLieOnTheSurfacesAtTheirOwnInstant) {
  const auto model = test::awkward_model(16, 360);
  const auto trajectory = test::drive(3, 0.5);
  const double speed = 5;
  const SimulatedScan scan = first_scan(room(speed, Material::brick), exact());
  int on_cube = 0;
  for (std::size_t i = 0; i < scan.records.size(); ++i) {
    SCOPED_TRACE(i);
    const LidarRecord& r = scan.records[i];
    ASSERT_EQ(r.code, ReturnCode::hit);
    const Time t = scan.start + Duration::from_nanoseconds(r.time_ns);
    const Vector3d p_0 = trajectory->at(t).T_v0.inverse() * r.position_v.cast<double>();
    const bool cube = scan.labels[i] >> 16 == 5;
    on_cube += cube;
    EXPECT_EQ(scan.labels[i] & 0xFFFF, cube ? kLabelDynamic : kLabelStatic);
    // Distance from the surface of a box about its own centre.
    const Vector3d centre = cube ? Vector3d(8, speed * t.seconds(), 0) : Vector3d::Zero();
    const Vector3d half = cube ? Vector3d(1, 1, 1) : Vector3d(20, 20, 10);
    EXPECT_NEAR(((p_0 - centre).cwiseAbs() - half).maxCoeff(), 0, 1e-3);
  }
  EXPECT_GT(on_cube, 50);
}

TEST(SimulatedSensor, TrueLabelsAreDynamicAbove0Point2MetresPerSecond) {
  for (const double speed : {0.19, 0.21}) {
    const SimulatedScan scan = first_scan(room(speed, Material::brick), exact());
    for (const std::uint32_t label : scan.labels) {
      if (label >> 16 != 5) continue;
      EXPECT_EQ(label & 0xFFFF, speed > 0.2 ? kLabelDynamic : kLabelStatic);
    }
  }
}

TEST(SimulatedSensor, NoiseHasTheGivenDeviationAndIsTheSameForAnyNumberOfThreads) {
  SensorOptions noisy = exact();
  noisy.range_noise_m = 0.05;
  const WorldDescription description = room(5, Material::brick);
  const SimulatedScan clean = first_scan(description, exact(), 3);
  const SimulatedScan parallel = first_scan(description, noisy, 3);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const SimulatedScan serial = first_scan(description, noisy, 3);
  double sum = 0;
  double squares = 0;
  const auto n = static_cast<double>(clean.records.size());
  for (std::size_t i = 0; i < clean.records.size(); ++i) {
    ASSERT_EQ(parallel.records[i].position_v, serial.records[i].position_v);
    const Vector3d origin =
        test::awkward_model(16, 360)->point_v(clean.records[i].laser, clean.records[i].column, 0);
    const double error = (parallel.records[i].position_v.cast<double>() - origin).norm() -
                         (clean.records[i].position_v.cast<double>() - origin).norm();
    sum += error;
    squares += error * error;
  }
  // Five standard errors of mean and deviation.
  EXPECT_NEAR(sum / n, 0, 5 * 0.05 / std::sqrt(n));
  EXPECT_NEAR(std::sqrt(squares / n), 0.05, 5 * 0.05 / std::sqrt(2 * n));
}

SimulatedScan second_scan(const std::string& name, double duration_s, std::size_t threads) {
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
  SceneOptions options;
  options.seed = 8;
  options.duration_s = duration_s;
  const Scene scene = make_scene(name, options);
  SimulatedWorld world(scene.world);
  const auto trajectory = std::make_shared<const SampledTrajectory>(scene.poses, Duration(), "test");
  SimulatedSensor sensor(std::make_shared<const LidarModel>(named_model("VLP-16")), trajectory, world,
                         SensorOptions());
  return sensor.scan(1);
}

TEST(SimulatedSensor, EverySceneIsTheSameForAnyDurationAndNumberOfThreads) {
  for (const std::string& name : scene_names()) {
    SCOPED_TRACE(name);
    const SimulatedScan one = second_scan(name, 0.2, 1);
    const SimulatedScan two = second_scan(name, 0.9, 4);
    EXPECT_EQ(one.labels, two.labels);
    EXPECT_EQ(one.intensities, two.intensities);
    ASSERT_EQ(one.records.size(), two.records.size());
    for (std::size_t i = 0; i < one.records.size(); ++i) {
      ASSERT_EQ(one.records[i].code, two.records[i].code) << i;
      if (one.records[i].code != ReturnCode::hit) continue;
      ASSERT_EQ(one.records[i].position_v, two.records[i].position_v) << i;
    }
  }
}

TEST(SimulatedSensor, DistinguishesFaultyReturnsFromNothingWithinRange) {
  WorldDescription glass = room(0, Material::glass);
  SensorOptions options = exact();
  options.faulty = true;
  int faulty = 0;
  for (const LidarRecord& r : first_scan(glass, options).records) {
    EXPECT_NE(r.code, ReturnCode::nothing);
    faulty += r.code == ReturnCode::faulty;
  }
  EXPECT_GT(faulty, 1000);
  WorldDescription empty;
  for (const LidarRecord& r : first_scan(empty, options).records) EXPECT_EQ(r.code, ReturnCode::nothing);
}

TEST(SimulatedSensor, EveryNamedModelFiresEveryLaserInEveryColumn) {
  SimulatedWorld world(room(5, Material::brick));
  for (const std::string& name : named_models()) {
    SCOPED_TRACE(name);
    const auto model = std::make_shared<LidarModel>(named_model(name));
    SimulatedSensor sensor(model, test::drive(0, 0), world, exact());
    const SimulatedScan scan = sensor.scan(1);
    ASSERT_EQ(scan.records.size(), model->lasers.size() * static_cast<std::size_t>(model->columns));
    std::size_t hits = 0;
    for (const LidarRecord& r : scan.records) hits += r.code == ReturnCode::hit;
    EXPECT_EQ(hits, scan.records.size());
  }
}

TEST(SimulatedSensor, RefusesInvalidArguments) {
  WorldDescription description;
  SimulatedWorld world(description);
  const auto model = std::make_shared<const LidarModel>(named_model("VLP-16"));
  const auto trajectory = std::make_shared<const StationaryTrajectory>();
  EXPECT_NO_THROW(SimulatedSensor(model, trajectory, world, {}));
  EXPECT_THROW(SimulatedSensor(nullptr, trajectory, world, {}), ParameterError);
  EXPECT_THROW(SimulatedSensor(model, nullptr, world, {}), ParameterError);
  EXPECT_THROW(SimulatedSensor(std::make_shared<const LidarModel>(), trajectory, world, {}), InputError);
  for (const double noise_m : {-0.1, std::nan(""), 11.0}) {
    SensorOptions options;
    options.range_noise_m = noise_m;
    EXPECT_THROW(SimulatedSensor(model, trajectory, world, options), ParameterError) << noise_m;
  }
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
