#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "simulation/scenes/random/draws.hpp"
#include <mapless/io/labels.hpp>
#include <mapless/simulation/scene.hpp>

namespace mapless {
namespace MAPLESS_FILE {

using Eigen::Vector3d;

constexpr std::uint64_t kSeeds = 12;

Scene drawn(std::uint64_t seed, double duration_s = 1) {
  SceneOptions options;
  options.seed = seed;
  options.duration_s = duration_s;
  options.arbitrary_world = false;
  return make_scene("random", options);
}

SE3 sensor_at(const Scene& scene, double t_s) {
  const auto step = static_cast<std::size_t>(std::lround((t_s + 0.1) * 200));
  return scene.poses.at(step).T_v0.inverse();
}

/// Rays from the sensor in directions spread evenly over the sphere (Fibonacci), all at one instant.
std::vector<TimedRay> rays_around(const Scene& scene, double t_s, int count) {
  std::vector<TimedRay> rays;
  const Vector3d origin = sensor_at(scene, t_s).translation();
  for (int i = 0; i < count; ++i) {
    const double z = 1 - (2 * i + 1.0) / count;
    const double a = i * std::numbers::pi * (3 - std::sqrt(5.0));
    const double r = std::sqrt(1 - z * z);
    rays.push_back({origin, {r * std::cos(a), r * std::sin(a), z}, Time::from_seconds(t_s)});
  }
  return rays;
}

double speed_of(const Motion& T_0b, double t_s) {
  const auto at = [&](double t) { return Vector3d(T_0b(Time::from_seconds(t)).translation()); };
  return (at(t_s + 0.01) - at(t_s - 0.01)).norm() / 0.02;
}

TEST(RandomScene, TheSameSeedGivesTheSameScan) {
  const auto model = std::make_shared<const LidarModel>(model_from_name_or_file("VLP-16"));
  const auto scan = [&] {
    const Scene scene = drawn(7);
    SimulatedWorld world(scene.world);
    const auto trajectory = std::make_shared<const SampledTrajectory>(scene.poses, Duration(), "scene");
    return SimulatedSensor(model, trajectory, world, {}).scan(1);
  };
  const SimulatedScan a = scan();
  const SimulatedScan b = scan();
  EXPECT_EQ(a.labels, b.labels);
  EXPECT_EQ(a.intensities, b.intensities);
  for (std::size_t i = 0; i < a.records.size(); ++i) {
    if (a.records[i].code != ReturnCode::hit) continue;
    ASSERT_EQ(a.records[i].position_v, b.records[i].position_v) << i;
  }
}

TEST(RandomScene, SeedsDifferInPlaceMotionAndMovers) {
  std::set<std::size_t> statics, movers;
  std::set<long> speeds, heights;
  double slowest = 100, fastest = 0;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const Scene scene = drawn(seed);
    const Vector3d moved = sensor_at(scene, 0.6).translation() - sensor_at(scene, 0.5).translation();
    const double speed = moved.norm() / 0.1;
    slowest = std::min(slowest, speed);
    fastest = std::max(fastest, speed);
    statics.insert(scene.world.statics.size());
    movers.insert(scene.world.movers.size());
    speeds.insert(std::lround(speed * 1000));
    heights.insert(std::lround(sensor_at(scene, 0.5).translation().z() * 1000));
  }
  EXPECT_GE(statics.size(), kSeeds - 4);  // tunnels all have two
  EXPECT_GE(movers.size(), kSeeds / 2);
  EXPECT_GE(speeds.size(), kSeeds - 2);  // tripods all stand
  EXPECT_EQ(heights.size(), kSeeds);
  EXPECT_LT(slowest, 2);
  EXPECT_GT(fastest, 5);
}

TEST(RandomScene, NothingIsFasterThan35MetresASecond) {
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    SCOPED_TRACE(seed);
    const Scene scene = drawn(seed);
    for (std::size_t i = 1; i < scene.poses.size(); ++i) {
      const Vector3d moved =
          scene.poses[i].T_v0.inverse().translation() - scene.poses[i - 1].T_v0.inverse().translation();
      ASSERT_LT(moved.norm() / 0.005, 35);
    }
    for (const Mover& mover : scene.world.movers) {
      for (const double t : {0.1, 0.5, 0.9}) ASSERT_LT(speed_of(mover.T_0b, t), 35) << mover.object_id;
    }
  }
}

TEST(RandomScene, TheSensorTouchesNothing) {
  for (const std::uint64_t seed : {2u, 4u, 7u, 9u, 10u, 14u}) {
    SCOPED_TRACE(seed);
    const Scene scene = drawn(seed, 6);
    SimulatedWorld world(scene.world);
    for (const double t : {0.0, 1.5, 3.0, 4.5, 6.0}) {
      const auto rays = rays_around(scene, t, 2000);
      world.prepare(rays.front().time, rays.front().time, rays.front().origin_0, 2);
      std::vector<std::optional<RayHit>> hits(rays.size());
      world.cast(rays, 2, hits);
      for (const auto& hit : hits) {
        if (!hit) continue;
        ASSERT_GT(hit->range_m, hit->carries_sensor ? 0.03 : 0.2)
            << t << " s, " << to_string(hit->object_class) << " " << hit->object_id;
      }
    }
  }
}

/// The velocity of a point of the mover if it belongs to the part whose motion explains `velocity` best.
double unexplained_mps(const Mover& mover, const Vector3d& p_0, const Vector3d& velocity, Time t) {
  constexpr Duration kHalf = Duration::from_nanoseconds(3'000'000);
  double least = 1e9;
  for (std::size_t part = 0; part < mover.parts.size(); ++part) {
    const Vector3d p_s = mover.T_0s(part, t).inverse() * p_0;
    const Vector3d moved = mover.T_0s(part, t + kHalf) * p_s - mover.T_0s(part, t - kHalf) * p_s;
    least = std::min(least, (moved / (2 * kHalf.seconds()) - velocity).norm());
  }
  return least;
}

TEST(RandomScene, HitsHaveTheVelocityOfTheirPartAndAllElseStands) {
  std::set<ObjectClass> seen;
  int on_movers = 0, unexplained = 0;
  for (const std::uint64_t seed : {1u, 7u, 9u}) {
    SCOPED_TRACE(seed);
    const Scene scene = drawn(seed, 2);
    std::map<int, const Mover*> movers;
    for (const Mover& mover : scene.world.movers) movers[mover.object_id] = &mover;
    SimulatedWorld world(scene.world);
    const auto rays = rays_around(scene, 1, 20'000);
    world.prepare(rays.front().time, rays.front().time, rays.front().origin_0, 100);
    std::vector<std::optional<RayHit>> hits(rays.size());
    world.cast(rays, 100, hits);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      if (!hits[i]) continue;
      const auto mover = movers.find(hits[i]->object_id);
      if (mover == movers.end()) {
        ASSERT_EQ(hits[i]->velocity_0.norm(), 0);
        continue;
      }
      const Vector3d p_0 = rays[i].origin_0 + hits[i]->range_m * rays[i].direction_0;
      const double off = unexplained_mps(*mover->second, p_0, hits[i]->velocity_0, rays[i].time);
      ++on_movers;
      if (off > 0.02 * hits[i]->velocity_0.norm() + 0.02) ++unexplained;  // a foot that is just put down
      seen.insert(mover->second->object_class);
    }
  }
  EXPECT_GE(seen.size(), 4u);
  EXPECT_GT(on_movers, 300);
  EXPECT_LT(unexplained, on_movers / 50);
}

TEST(RandomScene, TheOwnBodyIsStaticInTheLabelsThoughItMoves) {
  const Scene scene = drawn(7);
  const auto carrier = std::find_if(scene.world.movers.begin(), scene.world.movers.end(),
                                    [](const Mover& mover) { return mover.carries_sensor; });
  ASSERT_NE(carrier, scene.world.movers.end());
  EXPECT_GT(speed_of(carrier->T_0b, 0.5), 5);
  // It is rigidly mounted.
  const SE3 T_vb = sensor_at(scene, 0).inverse() * carrier->T_0b(Time());
  const SE3 later = sensor_at(scene, 1).inverse() * carrier->T_0b(Time::from_seconds(1));
  EXPECT_LT((T_vb.matrix() - later.matrix()).norm(), 1e-9);

  const auto model = std::make_shared<const LidarModel>(model_from_name_or_file("VLP-16"));
  SimulatedWorld world(scene.world);
  const auto trajectory = std::make_shared<const SampledTrajectory>(scene.poses, Duration(), "scene");
  const SimulatedScan scan = SimulatedSensor(model, trajectory, world, {}).scan(3);
  const auto own = static_cast<std::uint32_t>(carrier->object_id);
  const auto is_own = [own](std::uint32_t label) { return label >> 16 == own; };
  EXPECT_GT(std::count_if(scan.labels.begin(), scan.labels.end(), is_own), 500);
  EXPECT_EQ(std::count(scan.labels.begin(), scan.labels.end(), own << 16 | kLabelDynamic), 0);
}

TEST(RandomScene, VehiclesThatShuntGoOnInALongerRecording) {
  const Scene brief = drawn(10, 2);
  const Scene longer = drawn(10, 4);
  ASSERT_EQ(brief.world.movers.size(), longer.world.movers.size());
  ASSERT_EQ(brief.world.statics.size(), longer.world.statics.size());
  int vehicles = 0;
  for (std::size_t m = 0; m < brief.world.movers.size(); ++m) {
    const Time t = Time::from_seconds(2.05);
    ASSERT_EQ(brief.world.movers[m].T_0b(t).matrix(), longer.world.movers[m].T_0b(t).matrix()) << m;
    if (brief.world.movers[m].object_class <= ObjectClass::truck) ++vehicles;
  }
  EXPECT_GT(vehicles, 0);
}

TEST(RandomScene, ValuesAreDrawnByTheirWeights) {
  RandomSequence random(3, 1);
  std::map<int, int> count;
  for (int k = 0; k < 4000; ++k) ++count[draw_one<int>(random, {{1, 0.5}, {2, 0.0}, {3, 1.5}})];
  // A binomial share of 1/4 of 4000 has a standard deviation of 27.
  EXPECT_NEAR(count[1], 1000, 120);
  EXPECT_EQ(count[2], 0);
  EXPECT_EQ(count[1] + count[3], 4000);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
