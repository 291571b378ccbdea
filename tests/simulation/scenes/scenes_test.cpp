#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include <gtest/gtest.h>

#include "simulation/scenes/town.hpp"
#include "simulation/traffic/living.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/simulation/scene.hpp>

namespace mapless {
namespace MAPLESS_FILE {

using Eigen::Vector2d;
using Eigen::Vector3d;

SceneOptions lasting(double duration_s, std::uint64_t seed = 4) {
  SceneOptions options;
  options.duration_s = duration_s;
  options.seed = seed;
  return options;
}

Terrain flat() {
  return [](double, double) { return 0.0; };
}

std::shared_ptr<const Path> straight(double length) {
  return std::make_shared<Path>(std::vector<Vector2d>{{0, 0}, {length, 0}});
}

TEST(Scene, EverySceneHasMoversWithUniqueNumbersAndPosesAt200Hz) {
  for (const std::string& name : scene_names()) {
    SCOPED_TRACE(name);
    const Scene scene = make_scene(name, lasting(1));
    EXPECT_FALSE(scene.world.statics.empty());
    EXPECT_GE(scene.world.movers.size(), 8u);
    std::set<int> ids;
    for (const Mover& mover : scene.world.movers) {
      EXPECT_TRUE(ids.insert(mover.object_id).second);
      EXPECT_GT(mover.object_id, 0);
      EXPECT_LT(mover.object_id, 65536);
    }
    EXPECT_LE(scene.poses.front().time, Time());
    EXPECT_GE(scene.poses.back().time, Time::from_seconds(1));
    for (std::size_t i = 1; i < scene.poses.size(); ++i)
      EXPECT_EQ((scene.poses[i].time - scene.poses[i - 1].time).nanoseconds(), 5'000'000);
  }
}

TEST(Scene, ALongerDurationContinuesTheShorterOne) {
  for (const std::string& name : scene_names()) {
    SCOPED_TRACE(name);
    const Scene brief = make_scene(name, lasting(2));
    const Scene longer = make_scene(name, lasting(3));
    ASSERT_EQ(brief.world.movers.size(), longer.world.movers.size());
    ASSERT_EQ(brief.world.statics.size(), longer.world.statics.size());
    for (std::size_t i = 0; i < brief.poses.size(); ++i)
      ASSERT_EQ(brief.poses[i].T_v0.matrix(), longer.poses[i].T_v0.matrix()) << i;
    for (std::size_t m = 0; m < brief.world.movers.size(); ++m) {
      const Time t = Time::from_seconds(2.05);
      const Mover& a = brief.world.movers[m];
      const Mover& b = longer.world.movers[m];
      for (std::size_t p = 0; p < a.parts.size(); ++p)
        ASSERT_EQ(a.T_0s(p, t).matrix(), b.T_0s(p, t).matrix()) << m;
    }
  }
}

TEST(Scene, AnotherSeedGivesAnotherWorld) {
  for (const char* name : {"town2", "highway", "tunnel", "flyer"}) {
    SCOPED_TRACE(name);
    const Scene a = make_scene(name, lasting(1, 1));
    const Scene b = make_scene(name, lasting(1, 2));
    const auto place = [](const Scene& scene) {
      return Vector3d(scene.world.movers[0].T_0b(Time()).translation());
    };
    EXPECT_GT((place(a) - place(b)).norm(), 1e-3);
  }
}

TEST(Scene, TheWorldFrameIsRotatedByDefault) {
  SceneOptions options = lasting(1);
  const Scene turned = make_scene("flyer", options);
  options.arbitrary_world = false;
  const Scene level = make_scene("flyer", options);
  EXPECT_GT((turned.T_w0.rotation() * Vector3d::UnitZ() - Vector3d::UnitZ()).norm(), 0.05);
  EXPECT_EQ(level.T_w0.matrix(), SE3().matrix());
  // The same motion in either: T_vw T_w0 = T_v0.
  const SE3 T_v0 = turned.poses_in_world()[30].T_v0 * turned.T_w0;
  EXPECT_LT((T_v0.matrix() - level.poses[30].T_v0.matrix()).norm(), 1e-12);
}

TEST(Scene, UnknownNamesAndDurationsAreRefused) {
  EXPECT_THROW((void)make_scene("town3", lasting(1)), ParameterError);
  EXPECT_THROW((void)make_scene("town1", lasting(0)), ParameterError);
  EXPECT_THROW((void)make_scene("town1", lasting(601)), ParameterError);
  EXPECT_THROW((void)make_scene("town1", lasting(std::nan(""))), ParameterError);
}

TEST(Scene, TheTownsHaveTheRoadLengthsOfThePaper) {
  EXPECT_DOUBLE_EQ(town1_plan().road_length_m(), 2900);
  EXPECT_DOUBLE_EQ(town2_plan().road_length_m(), 1900);
}

TEST(Walker, ThePlantedFootIsStaticAndTheOtherMoves) {
  constexpr double kStride = 1.4;
  for (double s = 0.01; s < 0.49 * kStride; s += 0.02) {
    const Vector2d before = foot_of_walker(s, kStride, false) + Vector2d(s, 0);
    const Vector2d after = foot_of_walker(s + 0.005, kStride, false) + Vector2d(s + 0.005, 0);
    EXPECT_LT((after - before).norm(), 1e-12);
    const Vector2d other_before = foot_of_walker(s, kStride, true) + Vector2d(s, 0);
    const Vector2d other_after = foot_of_walker(s + 0.005, kStride, true) + Vector2d(s + 0.005, 0);
    EXPECT_GT(other_after.x(), other_before.x());
  }
}

TEST(Walker, LegReachesFromHipToFoot) {
  const Vector2d hip(0.1, 0.86);
  for (const Vector2d& foot : {Vector2d(0.4, 0.06), Vector2d(-0.3, 0.1), Vector2d(0.1, 0.2)}) {
    const LegPose leg = bend_leg(hip, foot, 0.46);
    EXPECT_NEAR((leg.knee - hip).norm(), 0.46, 1e-12);
    const Vector2d end = leg.knee + 0.46 * Vector2d(-std::sin(leg.lower_rad), -std::cos(leg.lower_rad));
    EXPECT_LT((end - foot).norm(), 1e-9);
    EXPECT_GE(leg.knee.x(), (hip.x() + foot.x()) / 2);  // knees bend ahead
  }
}

TEST(Track, IsTheIntegralOfItsSpeed) {
  Track track(straight(100), 2, flat());
  double s = 3;
  double v = 0;
  for (int k = 0; k < 20; ++k) {
    track.add(s, v);
    s += (v + v + 0.2) / 2 * Track::kStep_s;
    v += 0.2;
  }
  // Constant acceleration of 2 m/s^2.
  for (const double t : {0.0, 0.05, 0.73, 1.7}) {
    EXPECT_NEAR(track.distance_m(t), 3 + t * t, 1e-9);
    EXPECT_NEAR(track.speed(t), 2 * t, 1e-9);
  }
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
