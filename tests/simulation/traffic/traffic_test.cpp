#include "simulation/traffic/traffic.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>

#include <gtest/gtest.h>

#include "simulation/traffic/vehicles.hpp"
#include <mapless/simulation/scene.hpp>

namespace mapless {
namespace MAPLESS_FILE {

using Eigen::Vector2d;

Terrain flat() {
  return [](double, double) { return 0.0; };
}

std::shared_ptr<const Path> straight(double length) {
  return std::make_shared<Path>(std::vector<Vector2d>{{0, 0}, {length, 0}});
}

TEST(Traffic, FollowersStopBehindAStoppedLeaderAndAtRedLights) {
  RoadUser leader{ObjectClass::car, straight(2000), 150, 0.01, 2.7, 0};
  RoadUser follower{ObjectClass::car, straight(2000), 0, 14, 2.7, 0};
  const auto tracks = drive_all({leader, follower}, {}, flat(), 60, 1);
  const double gap = tracks[0]->distance_m(60) - tracks[1]->distance_m(60) - 4.4;
  EXPECT_GT(gap, 0.5);
  EXPECT_LT(gap, 6);
  EXPECT_LT(tracks[1]->speed(60), 0.2);

  const Junction junction{{200, 0}, 9, 15};  // red along x from the start until 21 s
  const auto one = drive_all({follower}, {junction}, flat(), 60, 1);
  EXPECT_LT(one[0]->distance_m(20.5) + 2.2, 191);
  EXPECT_GT(one[0]->distance_m(20.5) + 2.2, 180);
  EXPECT_GT(one[0]->distance_m(60), 230);
}

// From the west and, at the junction about the origin, to the north.
std::shared_ptr<const Path> left_turn() {
  std::vector<Vector2d> points = {{-150, -1.75}, {-10.5, -1.75}};
  for (double a = 0.2; a < 1.5; a += 0.2)
    points.emplace_back(-10.5 + 12.25 * std::sin(a), 10.5 - 12.25 * std::cos(a));
  points.emplace_back(1.75, 150);
  return std::make_shared<Path>(points);
}

double closest(const Track& a, const Track& b, double duration_s) {
  double least = 1e9;
  for (double t = 0; t < duration_s; t += 0.05)
    least = std::min(least, (a.pose(t).translation() - b.pose(t).translation()).norm());
  return least;
}

TEST(Traffic, VehiclesThatTurnLeftYieldToOncomingTraffic) {
  const Junction junction{{0, 0}, 10.5, 0};  // green along x for 15 s from the start
  const RoadUser turning{ObjectClass::car, left_turn(), 95, 10, 2.7, 0};
  const auto westwards = std::make_shared<Path>(std::vector<Vector2d>{{150, 1.75}, {-150, 1.75}});
  const RoadUser oncoming{ObjectClass::car, westwards, 95, 10, 2.7, 0};
  const auto tracks = drive_all({turning, oncoming}, {junction}, flat(), 40, 1);
  EXPECT_GT(closest(*tracks[0], *tracks[1], 40), 3);
  for (double t = 0; t < 15; t += 0.5) EXPECT_GT(tracks[1]->speed(t), 7) << t;
  EXPECT_GT(tracks[0]->distance_m(40), 200);  // and then it goes

  const auto alone = drive_all({turning}, {junction}, flat(), 40, 1);
  EXPECT_GT(alone[0]->distance_m(12), tracks[0]->distance_m(12) + 3);
}

TEST(Traffic, PedestriansCrossAtGreenAndTurningVehiclesWaitForThem) {
  const Junction junction{{0, 0}, 10.5, 0};
  const RoadUser turning{ObjectClass::car, left_turn(), 95, 10, 2.7, 0};
  // Walks east across the street to the north, 7 m from the middle of the junction.
  const auto eastwards = std::make_shared<Path>(std::vector<Vector2d>{{-20, 7}, {60, 7}});
  RoadUser walker{ObjectClass::person, eastwards, 14, 1.3, 0.8, 0};
  walker.crossings = {{14.5, 25.5, 0, true}};
  const auto tracks = drive_all({turning, walker}, {junction}, flat(), 60, 1);
  EXPECT_GT(closest(*tracks[0], *tracks[1], 60), 1.5);
  EXPECT_GT(tracks[0]->distance_m(60), 200);
  EXPECT_GT(tracks[1]->distance_m(60), 40);

  walker.start_m = 5;
  const Junction red{{0, 0}, 10.5, 15};  // not green along x until 21 s
  const auto waiting = drive_all({walker}, {red}, flat(), 60, 1);
  EXPECT_LT(waiting[0]->distance_m(20.5), 14.5);
  EXPECT_GT(waiting[0]->distance_m(60), 30);
}

TEST(Traffic, PedestriansWhoMeetEvadeEachOther) {
  const auto east = std::make_shared<Path>(std::vector<Vector2d>{{0, 0}, {60, 0}});
  const auto west = std::make_shared<Path>(std::vector<Vector2d>{{60, 0}, {0, 0}});
  const auto tracks =
      drive_all({{ObjectClass::person, east, 0, 1.3, 0.8, 0}, {ObjectClass::person, west, 0, 1.2, 0.8, 0}},
                {}, flat(), 40, 1);
  EXPECT_GT(closest(*tracks[0], *tracks[1], 40), 0.5);
  EXPECT_NEAR(tracks[0]->pose(39).translation().y(), 0, 0.05);
}

/// A mover seen from above.
struct Footprint {
  Vector2d centre, heading;
  double length, width;

  [[nodiscard]] Vector2d left() const { return {-heading.y(), heading.x()}; }
  [[nodiscard]] double reach(const Vector2d& axis) const {
    return std::abs(axis.dot(heading)) * length / 2 + std::abs(axis.dot(left())) * width / 2;
  }
};

bool overlap(const Footprint& a, const Footprint& b) {
  const Vector2d apart = b.centre - a.centre;
  const std::array<Vector2d, 4> axes = {a.heading, a.left(), b.heading, b.left()};
  return std::all_of(axes.begin(), axes.end(), [&](const Vector2d& axis) {
    return std::abs(axis.dot(apart)) < a.reach(axis) + b.reach(axis);
  });
}

Footprint footprint(ObjectClass c, const SE3& T_0b) {
  constexpr double kTouching = 0.1;
  const Vector2d heading = T_0b.rotation().col(0).head<2>().normalized();
  return {T_0b.translation().head<2>(), heading, body_length(c) - kTouching, body_width(c) - kTouching};
}

bool is_on_foot(ObjectClass c) { return c == ObjectClass::person || c == ObjectClass::dog; }

struct StreetLife {
  int vehicles_in_vehicles = 0, vehicles_in_parked = 0, moments = 0;
  int moving = 0, standing = 0;  // of the vehicles at the end
};

StreetLife watch(const Scene& scene, double duration_s) {
  StreetLife life;
  std::vector<Footprint> parked;
  for (const StaticObject& s : scene.world.statics)
    if (s.object_id > 0) parked.push_back(footprint(s.object_class, s.T_0s));
  for (double t = 0; t < duration_s; t += 0.5) {
    std::vector<Footprint> vehicles;
    for (const Mover& m : scene.world.movers) {
      if (is_on_foot(m.object_class)) continue;
      const auto at = [&](double when) { return m.T_0b(Time::from_seconds(when)); };
      const Footprint now = footprint(m.object_class, at(t));
      ++life.moments;
      const auto in_it = [&](const Footprint& other) { return overlap(now, other); };
      life.vehicles_in_vehicles += static_cast<int>(std::count_if(vehicles.begin(), vehicles.end(), in_it));
      life.vehicles_in_parked += static_cast<int>(std::count_if(parked.begin(), parked.end(), in_it));
      vehicles.push_back(now);
      if (t < duration_s - 30) continue;
      const double moved = (at(t + 0.1).translation() - at(t).translation()).norm();
      ++(moved > 0.02 ? life.moving : life.standing);
    }
  }
  return life;
}

TEST(Traffic, StopsAndStartsInTownWithoutCollisionsOrGridlock) {
  constexpr double kDuration_s = 150;
  for (const char* name : {"town1", "town2", "crossing"}) {
    SCOPED_TRACE(name);
    SceneOptions options;
    options.duration_s = kDuration_s;
    const StreetLife life = watch(make_scene(name, options), kDuration_s);
    EXPECT_LT(life.vehicles_in_vehicles, life.moments / 1000);
    EXPECT_EQ(life.vehicles_in_parked, 0);
    EXPECT_GT(life.moving, life.standing / 2);
    EXPECT_GT(life.standing, life.moving / 50);
  }
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
