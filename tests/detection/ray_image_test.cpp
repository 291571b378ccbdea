#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <string>

#include <gtest/gtest.h>
#include <tbb/parallel_for.h>

#include "oracle/freespace_probe_oracle.hpp"
#include "support/toy_scene.hpp"
#include <mapless/detection/ray_image.hpp>

namespace mapless {
namespace {

using Eigen::Vector3d;
using test::FreespaceProbeOracle;

constexpr double kDegree = std::numbers::pi / 180;
constexpr int kVerdicts = 5;

struct Case {
  std::string sensor;
  double speed;         // m/s
  double yaw_rate_deg;  // per second, counter-clockwise
  bool broken;          // some cells faulty, some absent, rays into the open
};

void PrintTo(const Case& c, std::ostream* out) {
  *out << c.sensor << " at " << c.speed << " m/s, " << c.yaw_rate_deg << " deg/s";
}

/// The furnished room, or the street with nothing moving, from a sensor that moves as the case says.
test::ToyScene scene_of(const Case& c) {
  const auto trajectory = test::drive(c.speed, c.yaw_rate_deg * kDegree);
  test::ToyScene scene = test::toy_room(c.sensor, trajectory);
  if (c.broken) scene.world = test::toy_street(c.sensor).world;
  return scene;
}

std::shared_ptr<const LidarScan> scan_of(const Case& c, const test::ToyScene& scene,
                                         std::mt19937_64& random) {
  auto scan = std::make_shared<LidarScan>(*test::cast_scan(scene, 3).scan);
  if (!c.broken) return scan;
  for (std::int32_t& cell : scan->cells) {
    const auto die = random() % 40;
    if (die < 2) cell = empty_cell(die == 0 ? ReturnCode::faulty : ReturnCode::absent);
  }
  return scan;
}

/// Near the ends of random rays: before, on and behind them, up to two lasers and some columns aside; and
/// anywhere, from 0.3 m to 150 m, above, below and behind too. Not where the sensor itself goes in the scan.
std::vector<Vector3d> queries_of(const CompensatedScan& scan, const FreespaceProbeOracle& oracle, int count,
                                 std::mt19937_64& random) {
  std::uniform_real_distribution<double> unit(0, 1), both(-1, 1);
  std::normal_distribution<double> normal;
  const auto& returns = scan.scan->returns;
  std::vector<Vector3d> queries;
  const Vector3d begin_0 = scan.column_T_0v.front().translation();
  const Vector3d end_0 = scan.column_T_0v.back().translation();
  for (int i = 0; queries.size() < static_cast<std::size_t>(count); ++i) {
    const LidarReturn& r = returns[random() % returns.size()];
    const Vector3d& origin = oracle.origin_0(r.laser, r.column);
    Vector3d direction = oracle.direction_0(r.laser, r.column);
    double range = r.range_m;
    if (i % 3 == 0) {
      direction = Vector3d(normal(random), normal(random), normal(random) / 3).normalized();
      range = 0.3 * std::pow(500.0, unit(random));
    } else {
      direction += 0.01 * Vector3d(both(random), both(random), both(random));
      range = i % 3 == 1 ? range + 0.6 * both(random) : range * (0.2 + 1.2 * unit(random));
    }
    const Vector3d q = origin + std::max(range, 0.3) * direction.normalized();
    const double way = (end_0 - begin_0).norm();
    if ((q - begin_0).norm() + (q - end_0).norm() > 1.4 * way) queries.push_back(q);
  }
  return queries;
}

FreespaceVerdict ask(const FreespaceProbe& probe, const Vector3d& origin_0, const Vector3d& q_0,
                     float column) {
  return probe.ask((q_0 - origin_0).cast<float>(), column);
}

/// A turning sensor sees a direction near its seam twice, or not at all.
bool is_right(const FreespaceProbeOracle& oracle, const Vector3d& q_0, FreespaceVerdict verdict, double seam,
              int columns) {
  if (oracle.ask(q_0) == verdict) return true;
  if (oracle.angle_from_seam(q_0) > seam) return false;
  return verdict == FreespaceVerdict::unobserved || oracle.ask(q_0, 0, columns / 2) == verdict ||
         oracle.ask(q_0, columns / 2, columns) == verdict;
}

enum class Asked { alone, by_fours };

struct ProbeAgreement : testing::TestWithParam<Case> {
  void expect_agreement(Asked asked) const;
};

/// The first guesses are bad, those of every other four good.
std::vector<FreespaceVerdict> ask_by_fours(const FreespaceProbe& probe, const Vector3d& origin_0,
                                           const std::vector<Vector3d>& queries) {
  std::vector<FreespaceVerdict> verdicts(queries.size());
  for (std::size_t i = 0; i < queries.size(); i += 4) {
    std::array<Eigen::Vector3f, 4> q;
    std::array<float, 4> columns{};
    for (std::size_t k = 0; k < 4; ++k) {
      q[k] = (queries[i + k] - origin_0).cast<float>();
      columns[k] = static_cast<float>((i + k) % 900);
      if (i % 8 == 0) (void)probe.look(q[k], columns[k]);
    }
    const auto answers = probe.look(q, columns);
    for (std::size_t k = 0; k < 4; ++k) verdicts[i + k] = answers[k].verdict;
  }
  return verdicts;
}

void ProbeAgreement::expect_agreement(Asked asked) const {
  const Case& c = GetParam();
  std::mt19937_64 random(17);
  const test::ToyScene scene = scene_of(c);
  const auto scan = scan_of(c, scene, random);
  const VotingParameters parameters;
  const CompensatedScan compensated = compensate(scan, *scene.trajectory);
  const RayImage image(compensated);
  const FreespaceProbeOracle oracle(*scan, *scene.trajectory, parameters);
  const std::vector<Vector3d> queries = queries_of(compensated, oracle, 600, random);
  const Vector3d origin_0 = image.origin_0() + Vector3d(30, -20, 1);  // of a scan of three seconds later
  const FreespaceProbe probe(image, origin_0, parameters);

  // As much of a turn as the sensor itself turns in a scan, the lasers' azimuth offsets, and as much as a
  // point near the sensor wanders as it passes.
  const double turned = std::abs(c.yaw_rate_deg) / 10 * kDegree;
  const double seam = turned > 0 || c.speed > 0 ? turned + 20 * kDegree : 0;
  std::vector<FreespaceVerdict> verdicts(queries.size());
  if (asked == Asked::by_fours) verdicts = ask_by_fours(probe, origin_0, queries);
  std::vector<char> right(queries.size());
  tbb::parallel_for(std::size_t{0}, queries.size(), [&](std::size_t i) {
    if (asked == Asked::alone) verdicts[i] = ask(probe, origin_0, queries[i], static_cast<float>(i % 900));
    right[i] = is_right(oracle, queries[i], verdicts[i], seam, scan->columns) ? 1 : 0;
  });
  std::array<int, kVerdicts> seen{};
  int other = 0;
  for (std::size_t i = 0; i < queries.size(); ++i) {
    ++seen[static_cast<std::size_t>(verdicts[i])];
    if (right[i]) continue;
    ++other;
    // Half a column aside the next firing is the nearest; a laser fires up to 60 us after its column.
    const double range = (queries[i] - origin_0).norm();
    // Near the seam the laser above may have looked there at the start of the scan, the one below at its end.
    const bool near_seam = oracle.angle_from_seam(queries[i]) < seam;
    const double slack = (near_seam ? 0.1 : 0.005) + range * (std::numbers::pi / scan->columns + 3e-4);
    EXPECT_LE(oracle.margin_m(queries[i], verdicts[i]), slack)
        << "query " << queries[i].transpose() << ": " << static_cast<int>(verdicts[i]) << " for "
        << static_cast<int>(oracle.ask(queries[i]));
  }
  // Two queries in three lie where verdicts change.
  EXPECT_LE(other, static_cast<int>(queries.size()) / 100);
  for (const FreespaceVerdict v : {FreespaceVerdict::inside, FreespaceVerdict::border,
                                   FreespaceVerdict::outside, FreespaceVerdict::unobserved})
    EXPECT_GT(seen[static_cast<std::size_t>(v)], 10) << "hardly tests verdict " << static_cast<int>(v);
}

TEST_P(ProbeAgreement, WithBruteForceOverAllRays) { expect_agreement(Asked::alone); }

TEST_P(ProbeAgreement, OfFourAtOnceWithBruteForceOverAllRays) { expect_agreement(Asked::by_fours); }

INSTANTIATE_TEST_SUITE_P(Sensors, ProbeAgreement,
                         testing::Values(Case{"HDL-64E-S2", 0, 0, false}, Case{"HDL-64E-S2", 10, 0, true},
                                         Case{"HDL-64E-S2", 1, 180, false},
                                         Case{"HDL-64E-S2", 1, -180, false}, Case{"HDL-64E-S3", 0, 0, true},
                                         Case{"HDL-64E-S3", 10, 30, true}, Case{"VLP-16", 0, 0, true},
                                         Case{"VLP-16", 10, 0, true}, Case{"VLP-16", 0, 180, false},
                                         Case{"VLP-16", 0, -180, false}, Case{"OS1-128", 10, 0, true},
                                         Case{"OS1-128", 1, 180, false}, Case{"Pandar64", 10, -30, true},
                                         Case{"Pandar64", 0, -180, false}),
                         [](const auto& instance) { return "Case" + std::to_string(instance.index); });

// Where a ray of a moving sensor ended, from its laser's own pose at its own instant in double precision.
TEST(FreespaceProbe, EndpointIsWhereTheRayEnded) {
  for (const char* sensor : {"HDL-64E-S2", "OS1-128"}) {
    SCOPED_TRACE(sensor);
    const auto room = test::toy_room(sensor, test::drive(5, 20 * kDegree));
    const auto scan = test::cast_scan(room, 3).scan;
    const CompensatedScan compensated = compensate(scan, *room.trajectory);
    const RayImage image(compensated);
    const Vector3d origin_0 = compensated.column_T_0v.front().translation();
    const FreespaceProbe probe(image, origin_0, {});
    const FreespaceProbeOracle oracle(*scan, *room.trajectory, {});
    ASSERT_GT(scan->returns.size(), 10000u);
    double worst = 0;
    for (std::size_t i = 0; i < scan->returns.size(); i += 7) {
      const LidarReturn& r = scan->returns[i];
      const Vector3d expected =
          oracle.origin_0(r.laser, r.column) + oracle.direction_0(r.laser, r.column) * r.range_m;
      const Vector3d end = origin_0 + probe.endpoint(r.laser, r.column).cast<double>();
      worst = std::max(worst, (end - expected).norm());
    }
    EXPECT_LT(worst, 1e-3);
  }
}

// The firing named is the one that passes nearest: asked about its own end, it is itself.
TEST(FreespaceProbe, NamesTheFiringThatPassesNearest) {
  const auto room = test::toy_room("HDL-64E-S2", test::drive(0, 0));
  const auto scan = test::cast_scan(room, 0).scan;
  const RayImage image(compensate(scan, *room.trajectory));
  const FreespaceProbe probe(image, Vector3d::Zero(), {});
  for (std::size_t i = 0; i < scan->returns.size(); i += 997) {
    const LidarReturn& r = scan->returns[i];
    float column = 0;
    const auto answer = probe.look(probe.endpoint(r.laser, r.column), column);
    EXPECT_EQ(answer.verdict, FreespaceVerdict::border);
    EXPECT_EQ(answer.laser, r.laser);
    EXPECT_EQ(answer.column, r.column);
  }
}

/// What a resting sensor saw, and how a probe answers about points given by azimuth, elevation and range from
/// it.
class Seen {
 public:
  Seen(const char* sensor, const test::ToyWorld& world,
       const std::shared_ptr<const Trajectory>& trajectory = std::make_shared<StationaryTrajectory>())
      : image_(make_image(sensor, world, trajectory)), probe_(image_, Vector3d::Zero(), {}) {}

  [[nodiscard]] FreespaceVerdict at(const Vector3d& q_0) const {
    return ask(probe_, Vector3d::Zero(), q_0, 0);
  }
  [[nodiscard]] FreespaceVerdict at(double elevation_deg, double range) const {
    const double elevation = elevation_deg * kDegree;
    return at({range * std::cos(elevation), 0, range * std::sin(elevation)});
  }

 private:
  static RayImage make_image(const char* sensor, const test::ToyWorld& world,
                             const std::shared_ptr<const Trajectory>& trajectory) {
    test::ToyScene scene;
    scene.model = std::make_shared<const LidarModel>(named_model(sensor));
    scene.trajectory = trajectory;
    scene.world = world;
    return RayImage(compensate(test::cast_scan(scene, 0).scan, *trajectory));
  }
  RayImage image_;
  FreespaceProbe probe_;
};

test::ToyBody wall_at(double x) { return test::toy_box({x + 0.5, 0, 0}, {0.5, 40, 40}); }

TEST(FreespaceProbe, BeforeOnAndBehindAWall) {
  for (const char* sensor : {"HDL-64E-S3", "VLP-16", "OS1-128", "Pandar64"}) {
    const Seen wall(sensor, {wall_at(10)});
    for (const double elevation : {-5.0, -1.0, 1.0}) {
      SCOPED_TRACE(testing::Message() << sensor << " at " << elevation);
      const double range = 10 / std::cos(elevation * kDegree);
      EXPECT_EQ(wall.at(elevation, range - 4), FreespaceVerdict::inside);
      EXPECT_EQ(wall.at(elevation, range - 0.25), FreespaceVerdict::inside);
      EXPECT_EQ(wall.at(elevation, range - 0.15), FreespaceVerdict::border);
      EXPECT_EQ(wall.at(elevation, range), FreespaceVerdict::border);
      EXPECT_EQ(wall.at(elevation, range + 0.15), FreespaceVerdict::border);
      EXPECT_EQ(wall.at(elevation, range + 0.25), FreespaceVerdict::outside);
      EXPECT_EQ(wall.at(elevation, range + 4), FreespaceVerdict::outside);
    }
  }
}

// Lasers at -3 and -5 degrees meet ground 1.73 m below after 33.1 m and 19.8 m. A point of the ground at -3.4
// degrees is 29.2 m off and 0.20 m from the upper beam, which goes on beyond it. Reach: 0.1 m and a quarter
// of 2 degrees at that range, 0.35 m. Half-way, at -4 degrees, no beam is within reach.
TEST(FreespaceProbe, GroundBetweenTwoLasersIsNeverInside) {
  const Seen ground("VLP-16", {test::toy_ground(-1.73)});
  const auto range = [](double elevation_deg) { return 1.73 / std::sin(-elevation_deg * kDegree); };
  EXPECT_EQ(ground.at(-3, range(-3)), FreespaceVerdict::border);
  EXPECT_EQ(ground.at(-3.4, range(-3.4)), FreespaceVerdict::unobserved);
  EXPECT_EQ(ground.at(-4, range(-4)), FreespaceVerdict::unobserved);
  EXPECT_NE(ground.at(-4.6, range(-4.6)), FreespaceVerdict::inside);
  EXPECT_EQ(ground.at(-3, 10), FreespaceVerdict::inside);
}

// A pole 0.1 m thick, 10 m ahead; a column is 0.2 degrees, 0.035 m there. Two columns beside its edge still
// look at it, five do not.
TEST(FreespaceProbe, BesideAThinPole) {
  const Seen pole("VLP-16", {test::toy_cylinder({10, 0, 0}, 0.05, 5), wall_at(20)});
  const Vector3d on(9.95, 0, 0.17);
  EXPECT_EQ(pole.at(on), FreespaceVerdict::border);
  EXPECT_EQ(pole.at(on - Vector3d(1, 0, 0)), FreespaceVerdict::inside);
  EXPECT_EQ(pole.at(on + Vector3d(2, 0, 0)), FreespaceVerdict::outside);
  for (const double side : {-1.0, 1.0}) {
    EXPECT_EQ(pole.at(on + Vector3d(0, side * 0.09, 0)), FreespaceVerdict::border);
    EXPECT_EQ(pole.at(on + Vector3d(0, side * 0.3, 0)), FreespaceVerdict::inside);
    // Farther off, some of the rays around end at the pole and some go on: no free space is proven.
    EXPECT_EQ(pole.at(Vector3d(14, side * 1.4 * 0.09, 0.24)), FreespaceVerdict::unobserved);
  }
}

// A quarter of a laser's spacing below the lowest beam, at -15 degrees, what it ran into says nothing of
// where a slanting surface goes on; a wall where it ended is a wall there too.
TEST(FreespaceProbe, BeyondTheOutermostBeamNothingIsInside) {
  const Seen wall("VLP-16", {wall_at(10)});
  const double beam_m = 10 / std::cos(15 * kDegree);
  EXPECT_EQ(wall.at(-15, beam_m), FreespaceVerdict::border);
  EXPECT_EQ(wall.at(-15, 5), FreespaceVerdict::inside);
  EXPECT_EQ(wall.at(-14.7, 5), FreespaceVerdict::inside);
  EXPECT_EQ(wall.at(-15.1, 5), FreespaceVerdict::inside);  // a twentieth of 2 degrees below
  EXPECT_EQ(wall.at(-15.5, 5), FreespaceVerdict::unobserved);
  EXPECT_EQ(wall.at(15.5, 5), FreespaceVerdict::unobserved);
  EXPECT_EQ(wall.at(-15.5, beam_m), FreespaceVerdict::border);
}

TEST(FreespaceProbe, OutOfSightNothingIsObserved) {
  const Seen wall("VLP-16", {wall_at(10)});
  EXPECT_EQ(wall.at(20, 8), FreespaceVerdict::unobserved);
  EXPECT_EQ(wall.at(-20, 8), FreespaceVerdict::unobserved);
  EXPECT_EQ(wall.at({0, 0, 5}), FreespaceVerdict::unobserved);
  EXPECT_EQ(wall.at({0, 0, -5}), FreespaceVerdict::unobserved);
}

// Rays into the open prove free space up to the maximum range; beyond, nothing is known to be free.
TEST(FreespaceProbe, FreeUpToTheMaximumRangeOnly) {
  const double max_range = named_model("VLP-16").max_range_m;
  const Seen open("VLP-16", {});
  EXPECT_EQ(open.at({max_range - 1, 0, 0.017 * max_range}), FreespaceVerdict::inside);
  EXPECT_NE(open.at({max_range + 1, 0, 0.017 * max_range}), FreespaceVerdict::inside);
  EXPECT_NE(open.at({1e5, 0, 0.0175e5}), FreespaceVerdict::inside);
}

TEST(FreespaceProbe, AScanWithoutReturnsProvesNothing) {
  for (const ReturnCode code : {ReturnCode::faulty, ReturnCode::absent}) {
    test::ToyScene scene;
    scene.model = std::make_shared<const LidarModel>(named_model("HDL-64E-S2"));
    scene.trajectory = std::make_shared<StationaryTrajectory>();
    scene.empty_code = code;
    const RayImage image(compensate(test::cast_scan(scene, 0).scan, *scene.trajectory));
    const FreespaceProbe probe(image, Vector3d::Zero(), {});
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> both(-1, 1);
    for (int i = 0; i < 500; ++i) {
      const Vector3d q(30 * both(random), 30 * both(random), 3 * both(random));
      EXPECT_EQ(ask(probe, Vector3d::Zero(), q, 0), FreespaceVerdict::unobserved);
    }
  }
}

// A sensor that turns 18 degrees against its spin while it scans leaves out 18 degrees of the world, ahead of
// the end of its scan. VLP-16: lasers without azimuth offsets, seam at start_azimuth.
TEST(FreespaceProbe, WhatATurningSensorLeftOutIsUnobserved) {
  const LidarModel model = named_model("VLP-16");
  const double spin = model.sign();
  const Seen left_out("VLP-16", {}, test::drive(0, -spin * 180 * kDegree));
  const Seen overlap("VLP-16", {}, test::drive(0, spin * 180 * kDegree));
  for (double from_start = -17; from_start < 18; from_start += 0.5) {
    const double azimuth = model.start_azimuth_rad + spin * from_start * kDegree;
    const Vector3d q(20 * std::cos(azimuth), 20 * std::sin(azimuth), 0.35);
    SCOPED_TRACE(from_start);
    EXPECT_EQ(overlap.at(q), FreespaceVerdict::inside);
    EXPECT_EQ(left_out.at(q), from_start < 0 ? FreespaceVerdict::unobserved : FreespaceVerdict::inside);
  }
}

// The column given is a guess: any number leads to the same answer, and comes back as the column found.
TEST(FreespaceProbe, AnyGuessWillDo) {
  const auto room = test::toy_room("HDL-64E-S2", test::drive(8, 0.3));
  const auto scan = test::cast_scan(room, 0).scan;
  const CompensatedScan compensated = compensate(scan, *room.trajectory);
  const RayImage image(compensated);
  const FreespaceProbe probe(image, Vector3d::Zero(), {});
  for (std::size_t i = 0; i < scan->returns.size(); i += 997) {
    const Eigen::Vector3f q = compensated.points_0[i].cast<float>();
    float found = static_cast<float>(scan->returns[i].column);
    const FreespaceVerdict verdict = probe.ask(q, found);
    EXPECT_EQ(verdict, FreespaceVerdict::border);
    const int from_seam = std::min(scan->returns[i].column, scan->columns - scan->returns[i].column);
    if (from_seam < 100) continue;
    for (float guess : {-1e6F, -3.0F, 0.0F, 700.0F, 5000.0F, 1e6F}) {
      EXPECT_EQ(probe.ask(q, guess), verdict);
      EXPECT_NEAR(guess, found, 0.05F);
    }
  }
}

}  // namespace
}  // namespace mapless
