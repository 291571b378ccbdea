#include "detection/published/freespace_check.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <string>

#include <gtest/gtest.h>
#include <tbb/parallel_for.h>

#include "oracle/freespace_oracle.hpp"
#include "support/detection/prepared.hpp"
#include "support/toy_scene.hpp"

namespace mapless {
namespace MAPLESS_FILE {

using Eigen::Vector3d;

FreespaceParameters nearest_ray_only() {
  FreespaceParameters p;
  p.border_window_rows = p.border_window_columns = 1;
  return p;
}

std::vector<std::int32_t> random_returns(const PreparedScan& scan, int count, unsigned seed) {
  std::mt19937_64 random(seed);
  std::vector<std::int32_t> queries;
  for (int i = 0; i < count; ++i)
    queries.push_back(static_cast<std::int32_t>(random() % scan.scan().returns.size()));
  return queries;
}

struct Case {
  std::string sensor;
  int query, reference;
  double threshold_m;
  bool window;
  ReturnCode empty_code;
  bool no_return_is_free;
};

void PrintTo(const Case& c, std::ostream* out) {
  *out << c.sensor << " " << c.query << " in " << c.reference;
}

class FreespaceAgreement : public testing::TestWithParam<Case> {};

// A verdict may differ only where two lengths were equal to the tenth of a millimetre; a scan keeps the
// sensor's motion between two columns to first order, the oracle exactly.
TEST_P(FreespaceAgreement, WithTheGeometryOfEveryRay) {
  const Case& c = GetParam();
  test::ToyScene street = test::toy_street(c.sensor);
  street.empty_code = c.empty_code;
  const PreparedScan query = test::prepare(test::cast_scan(street, c.query).scan, *street.trajectory);
  const PreparedScan reference = test::prepare(test::cast_scan(street, c.reference).scan, *street.trajectory);
  FreespaceParameters parameters = c.window ? FreespaceParameters{} : nearest_ray_only();
  parameters.no_return_is_free = c.no_return_is_free;

  const std::vector<std::int32_t> queries = random_returns(query, 1500, 4711);
  const auto verdicts = check_freespace(query, queries, reference.compensated, c.threshold_m, parameters);
  const test::FreespaceOracle oracle(reference.scan(), *street.trajectory);
  std::vector<test::OracleFreespace> expected(queries.size());
  tbb::parallel_for(std::size_t{0}, queries.size(), [&](std::size_t k) {
    const auto i = static_cast<std::size_t>(queries[k]);
    expected[k] = oracle.verdict(query.compensated.points_0[i], query.normals_0[i].cast<double>(),
                                 c.threshold_m, parameters);
  });
  std::array<int, 5> seen{};
  int other = 0;
  for (std::size_t k = 0; k < queries.size(); ++k) {
    ++seen[static_cast<std::size_t>(expected[k].verdict)];
    other += expected[k].margin_m > 1e-4 && verdicts[k] != expected[k].verdict ? 1 : 0;
  }
  EXPECT_LE(other, 1);  // 99.9 % of the rays are the same
  for (const FreespaceVerdict v : {FreespaceVerdict::inside, FreespaceVerdict::border,
                                   FreespaceVerdict::outside, FreespaceVerdict::unobserved})
    EXPECT_GT(seen[static_cast<std::size_t>(v)], 0)
        << "the scene does not test verdict " << static_cast<int>(v);
}

INSTANTIATE_TEST_SUITE_P(Scenes, FreespaceAgreement,
                         testing::Values(Case{"HDL-64E-S2", 20, 12, 0.2, true, ReturnCode::nothing, true},
                                         Case{"HDL-64E-S2", 45, 37, 0.2, false, ReturnCode::nothing, false},
                                         Case{"HDL-64E-S3", 40, 42, 0.1, true, ReturnCode::faulty, true},
                                         Case{"VLP-16", 44, 36, 0.2, true, ReturnCode::nothing, true},
                                         Case{"OS1-128", 50, 42, 0.5, false, ReturnCode::nothing, true}),
                         [](const auto& instance) { return "Case" + std::to_string(instance.index); });

/// A wall `range` m ahead of a resting sensor, and the verdicts on a wall elsewhere.
class Walls : public testing::Test {
 protected:
  static test::ToyScene wall_at(double range) {
    test::ToyScene scene;
    scene.model = std::make_shared<const LidarModel>(named_model("HDL-64E-S3"));
    scene.trajectory = std::make_shared<StationaryTrajectory>();
    if (range > 0) scene.world.push_back(test::toy_box({range + 0.5, 0, 0}, {0.5, 40, 40}));
    return scene;
  }
  static PreparedScan seen(const test::ToyScene& scene) {
    return test::prepare(test::cast_scan(scene, 0).scan, *scene.trajectory);
  }
  /// Share of the returns straight ahead of the query wall with this verdict. The walls end at 45 degrees or
  /// less, so that only rays well within both count.
  static double share(const PreparedScan& query, const PreparedScan& reference, FreespaceVerdict verdict,
                      const FreespaceParameters& parameters) {
    std::vector<std::int32_t> ahead;
    for (std::size_t i = 0; i < query.compensated.points_0.size(); ++i) {
      const Vector3d& p = query.compensated.points_0[i];
      if (std::abs(p.y()) < 0.5 * p.x()) ahead.push_back(static_cast<std::int32_t>(i));
    }
    const auto verdicts = check_freespace(query, ahead, reference.compensated, 0.2, parameters);
    const auto matching = std::count(verdicts.begin(), verdicts.end(), verdict);
    return static_cast<double>(matching) / static_cast<double>(ahead.size());
  }
};

TEST_F(Walls, BeforeOnAndBehindAWallSeenEarlier) {
  const PreparedScan earlier = seen(wall_at(10));
  for (const FreespaceParameters& p : {FreespaceParameters{}, nearest_ray_only()}) {
    EXPECT_EQ(share(seen(wall_at(6)), earlier, FreespaceVerdict::inside, p), 1);
    EXPECT_EQ(share(seen(wall_at(10.1)), earlier, FreespaceVerdict::border, p), 1);
    EXPECT_EQ(share(seen(wall_at(9.9)), earlier, FreespaceVerdict::border, p), 1);
    EXPECT_EQ(share(seen(wall_at(14)), earlier, FreespaceVerdict::outside, p), 1);
  }
}

TEST_F(Walls, ARayThatMetNothingProvesFreeOnlyWhereThatIsKnown) {
  const PreparedScan query = seen(wall_at(10));
  test::ToyScene empty = wall_at(0);
  EXPECT_EQ(share(query, seen(empty), FreespaceVerdict::inside, {}), 1);
  FreespaceParameters careful;
  careful.no_return_is_free = false;
  EXPECT_EQ(share(query, seen(empty), FreespaceVerdict::unobserved, careful), 1);
  empty.empty_code = ReturnCode::faulty;
  EXPECT_EQ(share(query, seen(empty), FreespaceVerdict::unobserved, {}), 1);
  empty.empty_code = ReturnCode::absent;
  EXPECT_EQ(share(query, seen(empty), FreespaceVerdict::unobserved, {}), 1);
}

// A tall wall is seen from 5 m below by a sensor whose rays never reached that height.
TEST_F(Walls, AboveTheHighestRayNothingIsObserved) {
  test::ToyScene high = wall_at(20);
  Vector6d up = Vector6d::Zero();
  up.z() = -5;
  high.trajectory = std::make_shared<test::SteadyTrajectory>(SE3::exp(up), Vector6d::Zero());
  const PreparedScan query = seen(high);
  const PreparedScan low = seen(wall_at(30));
  // S3 looks up by 2 degrees, a slope of 0.035, and its lasers are 0.5 degrees apart at most.
  std::vector<std::int32_t> above;
  for (std::size_t i = 0; i < query.compensated.points_0.size(); ++i)
    if (query.compensated.points_0[i].z() > 0.1 * query.compensated.points_0[i].head<2>().norm())
      above.push_back(static_cast<std::int32_t>(i));
  ASSERT_GT(above.size(), 100u);
  for (const auto v : check_freespace(query, above, low.compensated, 0.2, {}))
    EXPECT_EQ(v, FreespaceVerdict::unobserved);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
