#include "detection/published/pointcloud_comparison.hpp"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "oracle/comparison_oracle.hpp"
#include "support/detection/prepared.hpp"
#include "support/toy_scene.hpp"

namespace mapless {
namespace MAPLESS_FILE {

void expect_agreement(const PreparedScan& query, const PreparedScan& reference, int samples, unsigned seed) {
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  const ComparisonParameters parameters;
  const std::vector<CandidateVerdict> verdicts = compare_pointclouds(query, reference, parameters);
  ASSERT_EQ(verdicts.size(), query.scan().returns.size());
  std::mt19937_64 random(seed);
  int dynamic = 0;
  for (int s = 0; s < samples; ++s) {
    const std::size_t i = random() % verdicts.size();
    const test::OracleComparison expected = test::comparison_error(
        query.compensated.points_0[i], query.normals_0[i],
        static_cast<double>(query.scan().returns[i].range_m), reference.compensated.points_0, parameters);
    if (std::abs(expected.error_m - parameters.error_threshold_m) < 1e-9) continue;
    const bool moved = expected.compared && expected.error_m > parameters.error_threshold_m;
    EXPECT_EQ(verdicts[i] == CandidateVerdict::dynamic, moved) << "return " << i;
    dynamic += moved ? 1 : 0;
  }
  EXPECT_GT(dynamic, 0);  // else the scene tests nothing
}

TEST(PointcloudComparison, AgreesWithExhaustiveSearch) {
  const test::ToyScene street = test::toy_street("HDL-64E-S3");
  const PreparedScan query = test::prepare(test::cast_scan(street, 30).scan, *street.trajectory);
  const PreparedScan earlier = test::prepare(test::cast_scan(street, 22).scan, *street.trajectory);
  expect_agreement(query, earlier, 1500, 11);
  expect_agreement(earlier, query, 1500, 12);
}

TEST(PointcloudComparison, ComparesNothingWithAnEmptyScan) {
  test::ToyScene room = test::toy_room("VLP-16", test::drive(0, 0));
  const PreparedScan query = test::prepare(test::cast_scan(room, 1).scan, *room.trajectory);
  room.world.clear();
  const PreparedScan empty = test::prepare(test::cast_scan(room, 0).scan, *room.trajectory);
  ComparisonParameters near_only;  // points without a normal are not compared even with a full scan
  near_only.max_range_without_normal_m = 0;
  for (const CandidateVerdict v : compare_pointclouds(query, empty, near_only)) {
    EXPECT_EQ(v, CandidateVerdict::not_compared);
  }
  EXPECT_TRUE(compare_pointclouds(empty, query, {}).empty());
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
