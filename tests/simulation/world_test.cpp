#include <cmath>
#include <random>

#include <Eigen/Geometry>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <mapless/core/errors.hpp>
#include <mapless/simulation/scene.hpp>

namespace mapless {
namespace MAPLESS_FILE {

using Eigen::Vector3d;

constexpr double kMillimetre = 1e-3;

SE3 turn_z(double angle, const Vector3d& at) { return {rotation_z(angle), at}; }

Time seconds(double s) { return Time::from_seconds(s); }

/// A wall at x = 30 and a box of 2 x 2 x 2 m that moves by `motion`.
WorldDescription wall_and_box(Motion motion) {
  WorldDescription world;
  world.shapes.resize(2);
  world.shapes[0].add_quad({0, -50, -50}, {0, 50, -50}, {0, 50, 50}, {0, -50, 50}, Material::brick);
  world.shapes[1].add_box({-1, -1, -1}, {1, 1, 1}, Material::paint);
  world.statics.push_back({0, SE3(Eigen::Matrix3d::Identity(), {30, 0, 0}), ObjectClass::building, 0});
  Mover box;
  box.object_id = 7;
  box.T_0b = std::move(motion);
  box.parts.push_back({1, nullptr});
  world.movers.push_back(std::move(box));
  return world;
}

/// Where a ray enters the cube of half edge 1 about the origin of b.
std::optional<double> enter_box(const SE3& T_0b, const TimedRay& ray) {
  const SE3 T_b0 = T_0b.inverse();
  const Vector3d o = T_b0 * ray.origin_0;
  const Vector3d d = T_b0.rotation() * ray.direction_0;
  double near = 0;
  double far = 1e9;
  for (int i = 0; i < 3; ++i) {
    const double a = (-1 - o[i]) / d[i];
    const double b = (1 - o[i]) / d[i];
    near = std::max(near, std::min(a, b));
    far = std::min(far, std::max(a, b));
  }
  if (near > far) return std::nullopt;
  return near;
}

std::optional<RayHit> cast_one(const SimulatedWorld& world, const TimedRay& ray) {
  std::optional<RayHit> hit;
  world.cast({&ray, 1}, 120, {&hit, 1});
  return hit;
}

/// Rays of a sensor that drives and turns, towards the box and the wall, at their own instants in 0.1 s.
TimedRay random_ray(std::mt19937& random) {
  std::uniform_real_distribution<double> unit(0, 1);
  const double t = 0.1 * unit(random);
  const SE3 T_0v = turn_z(2 * t, {8 * t, 0, 1 * t});
  const Vector3d d = Vector3d(10, 3 * (2 * unit(random) - 1), 2 * (2 * unit(random) - 1)).normalized();
  return {T_0v * Vector3d(0.1, 0.02, 0.2), T_0v.rotation() * d, seconds(t)};
}

TEST(SimulatedWorld, HitsAgreeWithClosedFormGeometryAtTheRaysOwnTime) {
  const auto motion = [](Time t) {
    return turn_z(3 * t.seconds(), {15 - 20 * t.seconds(), 2 - 30 * t.seconds(), 0});
  };
  SimulatedWorld world(wall_and_box(motion));
  world.prepare(seconds(0), seconds(0.1), Vector3d::Zero(), 120);
  std::mt19937 random(3);
  int on_box = 0;
  for (int i = 0; i < 5000; ++i) {
    SCOPED_TRACE(i);
    const TimedRay ray = random_ray(random);
    const SE3 T_0b = motion(ray.time);
    const auto box = enter_box(T_0b, ray);
    // A ray within 2 mm of an edge may hit or miss.
    TimedRay beside = ray;
    bool sure = true;
    for (const double shift : {-0.002, 0.002}) {
      beside.origin_0 = ray.origin_0 + Vector3d(0, shift, 0);
      sure = sure && enter_box(T_0b, beside).has_value() == box.has_value();
      beside.origin_0 = ray.origin_0 + Vector3d(0, 0, shift);
      sure = sure && enter_box(T_0b, beside).has_value() == box.has_value();
    }
    if (!sure) continue;
    const auto hit = cast_one(world, ray);
    ASSERT_TRUE(hit);
    const double expected = box ? *box : (30 - ray.origin_0.x()) / ray.direction_0.x();
    EXPECT_EQ(hit->object_id, box ? 7 : 0);
    EXPECT_NEAR(hit->range_m, expected, kMillimetre);
    if (!box) continue;
    ++on_box;
    const Vector3d p = ray.origin_0 + expected * ray.direction_0;
    const Vector3d velocity = Vector3d(-20, -30, 0) + Vector3d(0, 0, 3).cross(p - T_0b.translation());
    EXPECT_LT((hit->velocity_0 - velocity).norm(), 0.01);
  }
  EXPECT_GT(on_box, 500);
}

TEST(SimulatedWorld, ARotatingSurfaceIsSlowNearTheAxisAndFastOutside) {
  SimulatedWorld world(wall_and_box([](Time t) { return turn_z(t.seconds(), {10, 0, 0}); }));
  world.prepare(seconds(0), seconds(0.1), Vector3d::Zero(), 120);
  // The face towards us is 1 m from the axis: the speed is the distance from the axis, 1 rad/s.
  const auto hit = cast_one(world, {{0, 0.5, 0}, {1, 0, 0}, seconds(0)});
  ASSERT_TRUE(hit);
  EXPECT_NEAR(hit->range_m, 9, kMillimetre);
  EXPECT_NEAR(hit->velocity_0.norm(), std::hypot(1, 0.5), 1e-3);
  EXPECT_NEAR(hit->cos_incidence, 1, 1e-6);
  EXPECT_EQ(hit->material, Material::paint);
}

TEST(SimulatedWorld, PartsMoveRelativeToTheirBody) {
  WorldDescription description = wall_and_box([](Time t) { return turn_z(0, {10 + t.seconds(), 0, 0}); });
  description.movers[0].parts[0].T_bs = [](Time t) { return turn_z(0, {0, 0, 5 - t.seconds()}); };
  SimulatedWorld world(std::move(description));
  world.prepare(seconds(1), seconds(1.1), Vector3d::Zero(), 120);
  const auto hit = cast_one(world, {{0, 0, 4.2}, {1, 0, 0}, seconds(1.05)});
  ASSERT_TRUE(hit);
  EXPECT_NEAR(hit->range_m, 10.05, kMillimetre);
  EXPECT_LT((hit->velocity_0 - Vector3d(1, 0, -1)).norm(), 1e-6);
}

TEST(SimulatedWorld, NothingIsHitBeyondTheGivenRange) {
  SimulatedWorld world(wall_and_box([](Time) { return turn_z(0, {1000, 0, 0}); }));
  world.prepare(seconds(0), seconds(0.1), Vector3d::Zero(), 120);
  const TimedRay ray{{0, 0, 0}, {1, 0, 0}, seconds(0)};
  std::optional<RayHit> hit;
  world.cast({&ray, 1}, 29.9, {&hit, 1});
  EXPECT_FALSE(hit);
  world.cast({&ray, 1}, 30.1, {&hit, 1});
  EXPECT_TRUE(hit);
}

TEST(SimulatedWorld, RefusesAnAbsentShape) {
  WorldDescription world = wall_and_box([](Time) { return SE3(); });
  world.statics[0].shape = 2;
  EXPECT_THROW(SimulatedWorld{std::move(world)}, InputError);
}

std::string refusal(const std::function<void()>& step) {
  try {
    step();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(SimulatedWorld, RefusesInvalidMovers) {
  const auto still = [](Time) { return SE3(); };
  const auto with = [&](auto change) {
    WorldDescription world = wall_and_box(still);
    change(world.movers[0]);
    return refusal([&] { SimulatedWorld{world}; });
  };
  EXPECT_EQ(with([](Mover&) {}), "");
  EXPECT_THAT(with([](Mover& m) { m.T_0b = nullptr; }), testing::HasSubstr("T_0b"));
  EXPECT_THAT(with([](Mover& m) { m.object_id = 0; }), testing::HasSubstr("1 to 65535"));
  EXPECT_THAT(with([](Mover& m) { m.object_id = 65536; }), testing::HasSubstr("65536"));
  EXPECT_THAT(with([](Mover& m) { m.radius_m = std::nan(""); }), testing::HasSubstr("radius_m"));
}

TEST(SimulatedWorld, RefusesRaysOutsideThePreparedInterval) {
  SimulatedWorld world(wall_and_box([](Time) { return SE3(); }));
  EXPECT_THROW(world.prepare(seconds(1), seconds(0), Vector3d::Zero(), 10), ParameterError);
  EXPECT_THROW(world.prepare(seconds(0), seconds(1), Vector3d::Zero(), -1), ParameterError);
  world.prepare(seconds(0), seconds(0.1), Vector3d::Zero(), 120);
  const TimedRay late{Vector3d::Zero(), Vector3d::UnitX(), seconds(0.2)};
  const TimedRay ray{Vector3d::Zero(), Vector3d::UnitX(), seconds(0.1)};
  EXPECT_THAT(refusal([&] { (void)cast_one(world, late); }), testing::HasSubstr("prepared interval"));
  std::optional<RayHit> hit;
  EXPECT_THROW(world.cast({&ray, 1}, 120, {&hit, 0}), ParameterError);
  EXPECT_THROW(world.cast({&ray, 1}, std::nan(""), {&hit, 1}), ParameterError);
  EXPECT_NO_THROW(world.cast({&ray, 1}, 120, {&hit, 1}));
}

TEST(Mesh, RefusesDegenerateShapes) {
  Mesh mesh;
  const Material m = Material::wood;
  EXPECT_THROW(mesh.add_frustum({0, 0, 0}, 1, {0, 0, 1}, 1, 2, m), ParameterError);
  EXPECT_THROW(mesh.add_frustum({0, 0, 0}, -1, {0, 0, 1}, 1, 8, m), ParameterError);
  EXPECT_THROW(mesh.add_frustum({0, 0, 1}, 1, {0, 0, 1}, 1, 8, m), ParameterError);
  EXPECT_THROW(mesh.add_extrusion({{0, 0}, {1, 0}}, 1, m), ParameterError);
  EXPECT_THROW(mesh.add_ellipsoid({0, 0, 0}, {1, 1, 1}, 1, m), ParameterError);
  EXPECT_TRUE(mesh.triangles.empty());
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
