#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <numbers>
#include <random>
#include <string>
#include <tuple>

#include <gtest/gtest.h>
#include <tbb/parallel_for.h>

#include "detection/freespace/freespace_probe.hpp"
#include "oracle/freespace_probe_oracle.hpp"
#include "support/toy_scene.hpp"

namespace mapless {
namespace MAPLESS_FILE {

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

FreespaceVerdict verdict_of(const FreespaceProbe& probe, const Vector3d& origin_0, const Vector3d& q_0,
                            float column) {
  return probe.verdict((q_0 - origin_0).cast<float>(), column);
}

/// A turning sensor sees a direction near its seam twice, or not at all.
bool is_right(const FreespaceProbeOracle& oracle, const Vector3d& q_0, FreespaceVerdict verdict, double seam,
              int columns) {
  if (oracle.verdict(q_0) == verdict) return true;
  if (oracle.angle_from_seam(q_0) > seam) return false;
  return verdict == FreespaceVerdict::unobserved || oracle.verdict(q_0, 0, columns / 2) == verdict ||
         oracle.verdict(q_0, columns / 2, columns) == verdict;
}

enum class Mode { alone, side_by_side };

struct ProbeAgreement : testing::TestWithParam<Case> {
  void expect_agreement(Mode mode, SurfaceSlopes slopes = {}) const;
};

using Vectors = FreespaceProbe::Vectors;
constexpr std::size_t kAtOnce = FreespaceProbe::kAtOnce;

/// From query `first` on. The guesses of every other eight are bad, those of the others good for one of them.
FreespaceProbe::Points points_of(const FreespaceProbe& probe, const Vector3d& origin_0,
                                 const std::vector<Vector3d>& queries, std::size_t first,
                                 SurfaceSlopes slopes = {}) {
  FreespaceProbe::Points points;
  points.slope_up.fill(slopes.up);
  points.slope_left.fill(slopes.left);
  for (std::size_t k = 0; k < kAtOnce; ++k) {
    const Eigen::Vector3f q = (queries[first + k] - origin_0).cast<float>();
    points.x[k] = q.x();
    points.y[k] = q.y();
    points.z[k] = q.z();
  }
  points.near = static_cast<float>(first % 900);
  if (first % (2 * kAtOnce) == 0) (void)probe.observe({points.x[0], points.y[0], points.z[0]}, points.near);
  return points;
}

/// A scan of the case and points to observe.
struct Inquiry {
  Inquiry(const Case& c, int count, std::uint64_t seed, SurfaceSlopes slopes = {})
      : random(seed),
        scene(scene_of(c)),
        scan(scan_of(c, scene, random)),
        compensated(compensate(scan, *scene.trajectory)),
        image(compensated),
        origin_0(image.origin_0() + Vector3d(30, -20, 1)),  // of a scan of three seconds later
        probe(image, origin_0, parameters),
        oracle(*scan, *scene.trajectory, parameters, slopes),
        queries(queries_of(compensated, oracle, count, random)) {}
  Inquiry(const Inquiry&) = delete;
  Inquiry& operator=(const Inquiry&) = delete;

  std::mt19937_64 random;
  test::ToyScene scene;
  std::shared_ptr<const LidarScan> scan;
  CompensatedScan compensated;
  RayImage image;
  Vector3d origin_0;
  VotingParameters parameters;
  FreespaceProbe probe;
  FreespaceProbeOracle oracle;
  std::vector<Vector3d> queries;
};

std::vector<FreespaceVerdict> observe_side_by_side(const FreespaceProbe& probe, const Vector3d& origin_0,
                                                   const std::vector<Vector3d>& queries,
                                                   SurfaceSlopes slopes) {
  std::vector<FreespaceVerdict> verdicts(queries.size());
  for (std::size_t i = 0; i < queries.size(); i += kAtOnce) {
    FreespaceProbe::Points points = points_of(probe, origin_0, queries, i, slopes);
    const auto answers = probe.observe(points);
    for (std::size_t k = 0; k < kAtOnce; ++k) verdicts[i + k] = answers[k].verdict;
  }
  return verdicts;
}

void ProbeAgreement::expect_agreement(Mode mode, SurfaceSlopes slopes) const {
  const Case& c = GetParam();
  const Inquiry inquiry(c, 600, 17, slopes);
  const FreespaceProbe& probe = inquiry.probe;
  const FreespaceProbeOracle& oracle = inquiry.oracle;
  const std::vector<Vector3d>& queries = inquiry.queries;
  const int columns = inquiry.scan->columns;

  // As much of a turn as the sensor itself turns in a scan, the lasers' azimuth offsets, and as much as a
  // point near the sensor wanders as it passes.
  const double turned = std::abs(c.yaw_rate_deg) / 10 * kDegree;
  const double seam = turned > 0 || c.speed > 0 ? turned + 20 * kDegree : 0;
  std::vector<FreespaceVerdict> verdicts(queries.size());
  if (mode == Mode::side_by_side) verdicts = observe_side_by_side(probe, inquiry.origin_0, queries, slopes);
  std::vector<char> right(queries.size());
  tbb::parallel_for(std::size_t{0}, queries.size(), [&](std::size_t i) {
    if (mode == Mode::alone)
      verdicts[i] = verdict_of(probe, inquiry.origin_0, queries[i], static_cast<float>(i % 900));
    right[i] = is_right(oracle, queries[i], verdicts[i], seam, columns) ? 1 : 0;
  });
  std::array<int, kVerdicts> seen{};
  int other = 0;
  for (std::size_t i = 0; i < queries.size(); ++i) {
    ++seen[static_cast<std::size_t>(verdicts[i])];
    if (right[i]) continue;
    ++other;
    // Half a column aside the next firing is the nearest; a laser fires up to 60 us after its column.
    const double range = (queries[i] - inquiry.origin_0).norm();
    // Near the seam the laser above may have looked there at the start of the scan, the one below at its end.
    const bool near_seam = oracle.angle_from_seam(queries[i]) < seam;
    const double slack = (near_seam ? 0.1 : 0.005) + range * (std::numbers::pi / columns + 3e-4);
    EXPECT_LE(oracle.margin_m(queries[i], verdicts[i]), slack)
        << "query " << queries[i].transpose() << ": " << static_cast<int>(verdicts[i]) << " for "
        << static_cast<int>(oracle.verdict(queries[i]));
  }
  // Two queries in three lie where verdicts change.
  EXPECT_LE(other, static_cast<int>(queries.size()) / 100);
  for (const FreespaceVerdict v : {FreespaceVerdict::inside, FreespaceVerdict::border,
                                   FreespaceVerdict::outside, FreespaceVerdict::unobserved})
    EXPECT_GT(seen[static_cast<std::size_t>(v)], 10) << "hardly tests verdict " << static_cast<int>(v);
}

// Where the nearest firing is half a column aside, the windows may lie a column farther on.
TEST_P(ProbeAgreement, OfSurfacesBesideTheWindowsWithBruteForce) {
  const Inquiry inquiry(GetParam(), 4000, 19);
  const auto& [probe, origin_0, queries] = std::tie(inquiry.probe, inquiry.origin_0, inquiry.queries);
  const double seam = 20 * kDegree + std::abs(GetParam().yaw_rate_deg) / 10 * kDegree;
  int beside = 0, other = 0;
  for (std::size_t i = 0; i < queries.size(); i += kAtOnce) {
    FreespaceProbe::Points points = points_of(probe, origin_0, queries, i);
    const auto answers = probe.observe(points);
    for (std::size_t k = 0; k < kAtOnce; ++k) {
      const Vector3d& q_0 = queries[i + k];
      if (answers[k].verdict != FreespaceVerdict::inside || inquiry.oracle.angle_from_seam(q_0) < seam)
        continue;
      const bool expected = inquiry.oracle.surface_beside(q_0);
      beside += expected ? 1 : 0;
      other += answers[k].surface_beside != expected ? 1 : 0;
    }
  }
  // Two columns on either side are a degree; of 1,024 only steep beams have some beside them.
  if (inquiry.scan->columns >= 1080) {
    EXPECT_GT(beside, 7);
  }
  EXPECT_LE(other, beside / 5 + 1);
}

TEST_P(ProbeAgreement, WithBruteForceOverAllRays) { expect_agreement(Mode::alone); }

TEST_P(ProbeAgreement, OfEightAtOnceWithBruteForceOverAllRays) { expect_agreement(Mode::side_by_side); }

// Slopes at which the tolerance of most points is between its least and its most.
TEST_P(ProbeAgreement, OfInclinedSurfacesWithBruteForceOverAllRays) {
  expect_agreement(Mode::side_by_side, {0.3F, 2});
}

// To the last bit, whatever lies beside a point: labels do not depend on the processor.
TEST_P(ProbeAgreement, OfVectorsOfEightWithVectorsOfFour) {
  if (FreespaceProbe::widest_vectors() == Vectors::of_four) GTEST_SKIP() << "of this processor";
  const Inquiry inquiry(GetParam(), 10000, 18);
  const auto& [probe, origin_0, queries] = std::tie(inquiry.probe, inquiry.origin_0, inquiry.queries);
  for (std::size_t i = 0; i < queries.size(); i += kAtOnce) {
    FreespaceProbe::Points fours = points_of(probe, origin_0, queries, i, {0.3F, 2});
    FreespaceProbe::Points eights = fours;
    const auto expected = probe.observe(fours, Vectors::of_four);
    const auto answers = probe.observe(eights, Vectors::of_eight);
    ASSERT_EQ(answers.verdict, expected.verdict) << "queries from " << i;
    ASSERT_EQ(answers.laser, expected.laser) << "queries from " << i;
    ASSERT_EQ(answers.column, expected.column) << "queries from " << i;
    ASSERT_EQ(answers.surface_beside, expected.surface_beside) << "queries from " << i;
    for (std::size_t k = 0; k < kAtOnce; ++k) {
      ASSERT_EQ(std::bit_cast<std::uint32_t>(answers.short_by_m[k]),
                std::bit_cast<std::uint32_t>(expected.short_by_m[k]))
          << "query " << i + k;
      ASSERT_EQ(eights.column[k], fours.column[k]) << "query " << i + k;
    }
  }
}

// Of many, each eight has the answers it has alone, to the last bit, where it is looked for as far beside its
// guess as the last of the eight before was found beside its own.
TEST_P(ProbeAgreement, OfManyAtOnceWithEightAlone) {
  const Inquiry inquiry(GetParam(), 2000, 19);
  const auto& [probe, origin_0, queries] = std::tie(inquiry.probe, inquiry.origin_0, inquiry.queries);
  for (const Vectors vectors : {Vectors::of_four, FreespaceProbe::widest_vectors()}) {
    std::vector<FreespaceProbe::Points> many;
    for (std::size_t i = 0; i < queries.size(); i += kAtOnce) {
      many.push_back(points_of(probe, origin_0, queries, i));
      many.back().near_last = static_cast<float>(i % 700);
    }
    std::vector<FreespaceProbe::Points> alone = many;
    std::vector<FreespaceProbe::Answers> answers(many.size());
    probe.observe(many, answers, vectors);
    for (std::size_t n = 0; n < alone.size(); ++n) {
      if (n > 0) alone[n].near += alone[n - 1].column[kAtOnce - 1] - alone[n - 1].near_last;
      const auto expected = probe.observe(alone[n], vectors);
      ASSERT_EQ(many[n].column, alone[n].column) << "eight " << n;
      ASSERT_EQ(answers[n].verdict, expected.verdict) << "eight " << n;
      ASSERT_EQ(answers[n].laser, expected.laser) << "eight " << n;
      ASSERT_EQ(answers[n].column, expected.column) << "eight " << n;
      ASSERT_EQ(std::memcmp(&answers[n].short_by_m, &expected.short_by_m, sizeof(expected.short_by_m)), 0)
          << "eight " << n;
      ASSERT_EQ(answers[n].aside_m, expected.aside_m) << "eight " << n;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Sensors, ProbeAgreement,
                         testing::Values(Case{"HDL-64E-S2", 0, 0, false}, Case{"HDL-64E-S2", 10, 0, true},
                                         Case{"HDL-64E-S2", 1, 180, false},
                                         Case{"HDL-64E-S2", 1, -180, false}, Case{"HDL-64E-S3", 0, 0, true},
                                         Case{"HDL-64E-S3", 10, 30, true}, Case{"VLP-16", 0, 0, true},
                                         Case{"VLP-16", 10, 0, true}, Case{"VLP-16", 0, 180, false},
                                         Case{"VLP-16", 0, -180, false}, Case{"OS1-128", 10, 0, true},
                                         Case{"OS1-128", 1, 180, false}, Case{"Pandar64", 10, -30, true},
                                         Case{"Pandar64", 0, -180, false}, Case{"HDL-32E", 10, 30, true}),
                         [](const auto& instance) { return "Case" + std::to_string(instance.index); });

}  // namespace MAPLESS_FILE
}  // namespace mapless
