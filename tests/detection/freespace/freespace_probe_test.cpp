#include "detection/freespace/freespace_probe.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <random>
#include <utility>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "oracle/freespace_probe_oracle.hpp"
#include "support/detection/standing_scene.hpp"
#include "support/toy_scene.hpp"

namespace mapless {
namespace MAPLESS_FILE {

using Eigen::Vector3d;
using test::FreespaceProbeOracle;
using test::wall_at;

constexpr double kDegree = std::numbers::pi / 180;

FreespaceVerdict verdict_of(const FreespaceProbe& probe, const Vector3d& origin_0, const Vector3d& q_0,
                            float column) {
  return probe.verdict((q_0 - origin_0).cast<float>(), column);
}

FreespaceProbe::Points eight_of(const Eigen::Vector3f& q) {
  FreespaceProbe::Points eight{};
  eight.x.fill(q.x());
  eight.y.fill(q.y());
  eight.z.fill(q.z());
  return eight;
}

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

// The answer's firing is the one that passes nearest: for the end of a firing, that firing.
TEST(FreespaceProbe, NamesTheFiringThatPassesNearest) {
  const auto room = test::toy_room("HDL-64E-S2", test::drive(0, 0));
  const auto scan = test::cast_scan(room, 0).scan;
  const RayImage image(compensate(scan, *room.trajectory));
  const FreespaceProbe probe(image, Vector3d::Zero(), {});
  for (std::size_t i = 0; i < scan->returns.size(); i += 997) {
    const LidarReturn& r = scan->returns[i];
    float column = 0;
    const auto answer = probe.observe(probe.endpoint(r.laser, r.column), column);
    EXPECT_EQ(answer.verdict, FreespaceVerdict::border);
    EXPECT_EQ(answer.laser, r.laser);
    EXPECT_EQ(answer.column, r.column);
  }
}

// Of a point beside a ray and one above it: less than half a column and half a laser spacing off, 9 and 140
// mm at the range of these points.
TEST(FreespaceProbe, AnswersHowFarAsideTheFiringPasses) {
  const auto room = test::toy_room("VLP-16", test::drive(0, 0));
  const auto scan = test::cast_scan(room, 0).scan;
  const RayImage image(compensate(scan, *room.trajectory));
  const FreespaceProbe probe(image, Vector3d::Zero(), {});
  int observed = 0;
  for (std::size_t i = 0; i < scan->returns.size(); i += 997) {
    const LidarReturn& r = scan->returns[i];
    const Eigen::Vector3f along = probe.endpoint(r.laser, r.column).normalized();
    const Eigen::Vector3f left = Eigen::Vector3f::UnitZ().cross(along).normalized();
    const Eigen::Vector3f up = along.cross(left);
    for (const auto& [aside_m, above_m] : {std::pair(0.006F, 0.002F), {-0.006F, 0.0F}, {0.002F, -0.03F}}) {
      const Eigen::Vector3f q = 5 * along + aside_m * left + above_m * up;
      float column = 0;
      const auto alone = probe.observe(q, column);
      if (alone.laser != r.laser) continue;  // above the highest laser, or below the lowest
      FreespaceProbe::Points eight = eight_of(q);
      const float expected_m = std::max(std::abs(aside_m), std::abs(above_m));
      EXPECT_NEAR(alone.aside_m, expected_m, 5e-4F);
      EXPECT_NEAR(probe.observe(eight)[3].aside_m, expected_m, 5e-4F);
      ++observed;
    }
  }
  EXPECT_GT(observed, 50);
}

/// The image of a sensor at rest, and the answers of a probe for points given by elevation and range from it.
class Seen {
 public:
  Seen(const LidarModel& sensor, const test::ToyWorld& world,
       const std::shared_ptr<const Trajectory>& trajectory = std::make_shared<StationaryTrajectory>())
      : image_(make_image(sensor, world, trajectory)), probe_(image_, Vector3d::Zero(), {}) {}
  Seen(const char* sensor, const test::ToyWorld& world,
       const std::shared_ptr<const Trajectory>& trajectory = std::make_shared<StationaryTrajectory>())
      : Seen(named_model(sensor), world, trajectory) {}

  [[nodiscard]] FreespaceVerdict at(const Vector3d& q_0) const {
    return verdict_of(probe_, Vector3d::Zero(), q_0, 0);
  }
  /// Whether rays beside the window of a point seen through ended at its range, of the point alone and beside
  /// seven others.
  [[nodiscard]] bool surface_beside(const Vector3d& q_0) const {
    const Eigen::Vector3f q = q_0.cast<float>();
    float column = 0;
    const FreespaceProbe::Answer alone = probe_.observe(q, column);
    EXPECT_EQ(alone.verdict, FreespaceVerdict::inside);
    FreespaceProbe::Points eight = eight_of(q);
    EXPECT_EQ(probe_.observe(eight)[6].surface_beside, alone.surface_beside);
    return alone.surface_beside;
  }
  /// At azimuth `left_deg`, of a point whose surface is inclined, alone and beside seven others.
  [[nodiscard]] FreespaceVerdict at(double elevation_deg, double left_deg, double range,
                                    SurfaceSlopes slopes) const {
    const Eigen::Vector3f q =
        (range * Vector3d(std::cos(elevation_deg * kDegree) * std::cos(left_deg * kDegree),
                          std::cos(elevation_deg * kDegree) * std::sin(left_deg * kDegree),
                          std::sin(elevation_deg * kDegree)))
            .cast<float>();
    float column = 0;
    const FreespaceVerdict alone = probe_.verdict(q, column, slopes);
    FreespaceProbe::Points eight = eight_of(q);
    eight.slope_up[5] = slopes.up;
    eight.slope_left[5] = slopes.left;
    EXPECT_EQ(probe_.observe(eight)[5].verdict, alone);
    return alone;
  }
  [[nodiscard]] FreespaceVerdict at(double elevation_deg, double range) const {
    const double elevation = elevation_deg * kDegree;
    return at({range * std::cos(elevation), 0, range * std::sin(elevation)});
  }

 private:
  static RayImage make_image(const LidarModel& sensor, const test::ToyWorld& world,
                             const std::shared_ptr<const Trajectory>& trajectory) {
    test::ToyScene scene;
    scene.model = std::make_shared<const LidarModel>(sensor);
    scene.trajectory = trajectory;
    scene.world = world;
    return RayImage(compensate(test::cast_scan(scene, 0).scan, *trajectory));
  }
  RayImage image_;
  FreespaceProbe probe_;
};

TEST(FreespaceProbe, BeforeOnAndBehindAWall) {
  for (const char* sensor : {"HDL-64E-S3", "VLP-16", "OS1-128", "Pandar64"}) {
    const Seen wall(sensor, {wall_at(10)});
    for (const double elevation : {-5.0, -1.0, 1.0}) {
      SCOPED_TRACE(testing::Message() << sensor << " at " << elevation);
      const double range = 10 / std::cos(elevation * kDegree);
      EXPECT_EQ(wall.at(elevation, range - 4), FreespaceVerdict::inside);
      EXPECT_EQ(wall.at(elevation, range - 0.3), FreespaceVerdict::inside);
      EXPECT_EQ(wall.at(elevation, range - 0.06), FreespaceVerdict::border);
      EXPECT_EQ(wall.at(elevation, range), FreespaceVerdict::border);
      EXPECT_EQ(wall.at(elevation, range + 0.06), FreespaceVerdict::border);
      EXPECT_EQ(wall.at(elevation, range + 0.3), FreespaceVerdict::outside);
      EXPECT_EQ(wall.at(elevation, range + 4), FreespaceVerdict::outside);
    }
  }
}

// 0.08 m and 0.4 of the spacing at the range. VLP-16, 2 degrees: 0.22 m at 10 m, 0.36 m at 20 m. OS1-128,
// 0.35 degrees: 0.10 m and 0.13 m. On the beam above a flat wall is up to 4 cm farther.
TEST(FreespaceProbe, ToleratesMoreWhereLasersAreFartherApart) {
  struct Case {
    const char* sensor;
    double wall_m, tolerance_m;
  };
  for (const auto& [sensor, wall_m, tolerance_m] :
       {Case{"VLP-16", 10, 0.22}, {"VLP-16", 20, 0.36}, {"OS1-128", 10, 0.10}, {"OS1-128", 20, 0.13}}) {
    SCOPED_TRACE(testing::Message() << sensor << " at " << wall_m);
    const Seen wall(sensor, {wall_at(wall_m)});
    EXPECT_EQ(wall.at(1, wall_m - tolerance_m + 0.05), FreespaceVerdict::border);
    EXPECT_EQ(wall.at(1, wall_m - tolerance_m - 0.05), FreespaceVerdict::inside);
    EXPECT_EQ(wall.at(1, wall_m + tolerance_m - 0.05), FreespaceVerdict::border);
    EXPECT_EQ(wall.at(1, wall_m + tolerance_m + 0.05), FreespaceVerdict::outside);
  }
}

// A point half-way between two beams 2 degrees apart is 0.35 m from either at 20 m, and half-way between two
// columns 0.2 degrees apart 0.035 m. Where its surface is square to the rays, one that ends 0.08 m off does
// not end on it; where it recedes by 0.5 m per metre up, one within 0.08 + 0.17 m may, by 4 m per metre to
// the left one within 0.08 + 0.14 m; by 2 m per metre up one within 0.36 m, the most.
TEST(FreespaceProbe, ToleratesWhatTheSurfacesSlopesExplain) {
  const Seen wall("VLP-16", {wall_at(20)});
  struct Case {
    double left_deg;
    SurfaceSlopes slopes;
    double tolerance_m;
  };
  for (const auto& [left_deg, slopes, tolerance_m] :
       {Case{0, {0, 0}, 0.08}, {0, {0.5F, 0}, 0.25}, {0.1, {0, 4}, 0.22}, {0, {2, 0}, 0.36}, {0, {}, 0.36}}) {
    SCOPED_TRACE(testing::Message() << "slopes " << slopes.up << ", " << slopes.left);
    EXPECT_EQ(wall.at(0, left_deg, 20 - tolerance_m + 0.03, slopes), FreespaceVerdict::border);
    EXPECT_EQ(wall.at(0, left_deg, 20 - tolerance_m - 0.03, slopes), FreespaceVerdict::inside);
    EXPECT_EQ(wall.at(0, left_deg, 20 + tolerance_m - 0.03, slopes), FreespaceVerdict::border);
    EXPECT_EQ(wall.at(0, left_deg, 20 + tolerance_m + 0.03, slopes), FreespaceVerdict::outside);
  }
}

// Lasers at -3 and -5 degrees meet ground 1.73 m below after 33.1 m and 19.8 m. A point of the ground at -3.4
// degrees is 29.2 m off and 0.20 m from the upper beam, which goes on beyond it; the lower one ends short. So
// do one and the other half-way, where either is the nearer.
TEST(FreespaceProbe, GroundBetweenTwoLasersIsNeverInside) {
  const Seen ground("VLP-16", {test::toy_ground(-1.73)});
  const auto range = [](double elevation_deg) { return 1.73 / std::sin(-elevation_deg * kDegree); };
  EXPECT_EQ(ground.at(-3, range(-3)), FreespaceVerdict::border);
  EXPECT_EQ(ground.at(-3.4, range(-3.4)), FreespaceVerdict::unobserved);
  EXPECT_NE(ground.at(-4, range(-4)), FreespaceVerdict::inside);
  EXPECT_NE(ground.at(-4.6, range(-4.6)), FreespaceVerdict::inside);
  EXPECT_EQ(ground.at(-3, 10), FreespaceVerdict::inside);
  EXPECT_EQ(ground.at(-4, 15), FreespaceVerdict::inside);  // 0.26 m from either beam
}

// A pole 0.1 m thick, 10 m ahead; a column is 0.2 degrees, 0.035 m there. Two columns beside its edge still
// hit it, five do not.
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

// The edge of that pole is 0.29 degrees aside. Columns of 0.1 degrees: the five nearest reach the edge from a
// point 0.69 degrees aside, but not from one at 0.92.
TEST(FreespaceProbe, LooksAsFarBesideAPointWhereColumnsAreFiner) {
  LidarModel fine = named_model("VLP-16");
  fine.columns *= 2;
  fine.rotation_rate_hz /= 2;
  const Seen pole(fine, {test::toy_cylinder({10, 0, 0}, 0.05, 5), wall_at(20)});
  for (const double side : {-1.0, 1.0}) {
    EXPECT_EQ(pole.at({9.95, side * 0.12, 0.17}), FreespaceVerdict::border);
    EXPECT_EQ(pole.at({9.95, side * 0.16, 0.17}), FreespaceVerdict::inside);
  }
}

// Five columns of 0.2 degrees reach the edge of the pole from a point 1.15 degrees aside, not from one at
// 1.49. The pole must be at the range of the point.
TEST(FreespaceProbe, TellsASurfaceBesideTheWindow) {
  const Seen pole("VLP-16", {test::toy_cylinder({10, 0, 0}, 0.05, 5), wall_at(20)});
  for (const double side : {-1.0, 1.0}) {
    EXPECT_TRUE(pole.surface_beside({9.95, side * 0.2, 0.17}));
    EXPECT_FALSE(pole.surface_beside({9.95, side * 0.26, 0.17}));
    EXPECT_FALSE(pole.surface_beside({9.5, side * 0.19, 0.17}));
  }
}

// At 61 degrees of elevation columns of 0.2 degrees are 0.097 apart: five are half a degree, ten are a
// degree. The edge of a pole 5 m away is at an azimuth of 0.58 degrees, the points are at 1.39, 1.85, 2.31
// and 3.01.
TEST(FreespaceProbe, LooksAsFarBesideAPointWhereBeamsRise) {
  LidarModel steep = named_model("VLP-16");
  for (Laser& laser : steep.lasers) laser.elevation_rad += 60 * kDegree;
  const Seen pole(steep, {test::toy_cylinder({5, 0, 0}, 0.05, 30)});
  const double up_m = 4.95 * std::tan(61 * kDegree);
  for (const double side : {-1.0, 1.0}) {
    EXPECT_EQ(pole.at({4.95, side * 0.12, up_m}), FreespaceVerdict::border);
    EXPECT_EQ(pole.at({4.95, side * 0.16, up_m}), FreespaceVerdict::inside);
    EXPECT_TRUE(pole.surface_beside({4.95, side * 0.2, up_m}));
    EXPECT_FALSE(pole.surface_beside({4.95, side * 0.26, up_m}));
  }
}

// A ray that ends short two columns beside a point, 0.1 m off at 14 m, may be at the object's own edge; at 25
// m, 0.17 m off, it is on something in front: rays pass on both sides of a pole, a column nearer to it.
TEST(FreespaceProbe, FarAwayARayTwoColumnsBesideDoesNotHide) {
  const Seen pole("VLP-16", {test::toy_cylinder({10, 0, 0}, 0.05, 5), wall_at(40)});
  const double step_deg = 0.005, column_deg = 360.0 / named_model("VLP-16").columns;
  const auto hidden_deg = [&](double range) {
    double sum = 0;
    for (double azimuth = -2; azimuth < 2; azimuth += step_deg) {
      const double a = azimuth * kDegree, e = 1 * kDegree;
      const Vector3d q = range * Vector3d(std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), std::sin(e));
      if (pole.at(q) != FreespaceVerdict::inside) sum += step_deg;
    }
    return sum;
  };
  EXPECT_NEAR(hidden_deg(14) - hidden_deg(25), 2 * column_deg, 0.02);
}

// A quarter of a laser's spacing below the lowest beam, at -15 degrees, its end does not show where a
// slanting surface goes on; a wall where it ended is a wall there too.
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
// The tolerance is 1.5 m there.
TEST(FreespaceProbe, FreeUpToTheMaximumRangeOnly) {
  const double max_range = named_model("VLP-16").max_range_m;
  const Seen open("VLP-16", {});
  EXPECT_EQ(open.at({max_range - 2, 0, 0.017 * max_range}), FreespaceVerdict::inside);
  EXPECT_NE(open.at({max_range + 2, 0, 0.017 * max_range}), FreespaceVerdict::inside);
  EXPECT_NE(open.at({1e5, 0, 0.0175e5}), FreespaceVerdict::inside);
}

TEST(FreespaceProbe, AScanWithoutReturnsObservesNothing) {
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
      EXPECT_EQ(verdict_of(probe, Vector3d::Zero(), q, 0), FreespaceVerdict::unobserved);
    }
  }
}

// A sensor that turns 18 degrees against its spin while it scans leaves out 18 degrees of the world, ahead of
// the end of its scan. VLP-16: lasers without azimuth offsets, seam at start_azimuth.
TEST(FreespaceProbe, DirectionsATurningSensorLeftOutAreUnobserved) {
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
    const FreespaceVerdict verdict = probe.verdict(q, found);
    EXPECT_EQ(verdict, FreespaceVerdict::border);
    const int from_seam = std::min(scan->returns[i].column, scan->columns - scan->returns[i].column);
    if (from_seam < 100) continue;
    for (float guess : {-1e6F, -3.0F, 0.0F, 700.0F, 5000.0F, 1e6F}) {
      EXPECT_EQ(probe.verdict(q, guess), verdict);
      EXPECT_NEAR(guess, found, 0.05F);
    }
  }
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
