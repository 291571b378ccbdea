// "Did the rays of that scan pass through this place?" has two implementations: FreespaceProbe (single
// precision, fast) and check_freespace (the published method, double precision). Where the answer does not
// depend on their tolerances both must give it.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <tbb/parallel_for.h>

#include "detection/freespace/freespace_probe.hpp"
#include "detection/published/freespace_check.hpp"
#include "oracle/ray_search_oracle.hpp"
#include "support/toy_scene.hpp"

namespace mapless {
namespace MAPLESS_FILE {

using Eigen::Vector3d;

struct Case {
  std::string sensor;
  double speed_mps;
  double yaw_rate_rps;
};

void PrintTo(const Case& c, std::ostream* out) {
  *out << c.sensor << " at " << c.speed_mps << " m/s, " << c.yaw_rate_rps << " rad/s";
}

/// A scan, and what every ray near a point says of it, one by one.
class Scene {
 public:
  explicit Scene(const Case& c)
      : scene_(test::toy_room(c.sensor, test::drive(c.speed_mps, c.yaw_rate_rps))),
        scan(test::cast_scan(scene_, 3).scan),
        compensated(compensate(scan, *scene_.trajectory)),
        oracle_(*scan, *scene_.trajectory) {
    for (const LidarReturn& r : scan->returns) {
      origins_0_.push_back(oracle_.origin_0(r.laser, r.column));
      directions_0_.push_back(oracle_.direction_0(r.laser, r.column));
    }
  }

  /// Along random rays, a little aside, before and behind their ends; none nearer than 2 m.
  [[nodiscard]] std::vector<Vector3d> queries(int count) const {
    std::mt19937_64 random(5);
    std::uniform_real_distribution<double> both(-1, 1), share(0.2, 2);
    std::vector<Vector3d> out;
    while (out.size() < static_cast<std::size_t>(count)) {
      const std::size_t i = random() % scan->returns.size();
      const Vector3d aside = 0.03 * Vector3d(both(random), both(random), both(random));
      const double range = share(random) * static_cast<double>(scan->returns[i].range_m);
      if (range > 2) out.push_back(origins_0_[i] + range * (directions_0_[i] + aside).normalized());
    }
    return out;
  }

  /// `inside` where all rays within kCone_rad of the point end clearly beyond it, `outside` where all end
  /// clearly short of it; nothing where neither holds.
  [[nodiscard]] std::optional<FreespaceVerdict> clear_verdict(const Vector3d& q_0) const {
    bool all_beyond = true, all_short = true;
    for (std::size_t i = 0; i < origins_0_.size() && (all_beyond || all_short); ++i) {
      const Vector3d to_q = q_0 - origins_0_[i];
      const double range = to_q.norm();
      if (to_q.dot(directions_0_[i]) < std::cos(kCone_rad) * range) continue;
      const double margin = kMargin_m + kMarginPerMetre * range;
      const auto ray_m = static_cast<double>(scan->returns[i].range_m);
      all_beyond = all_beyond && ray_m > range + margin;
      all_short = all_short && ray_m < range - margin;
    }
    if (all_beyond == all_short) return std::nullopt;
    return all_beyond ? FreespaceVerdict::inside : FreespaceVerdict::outside;
  }

 private:
  // More than the tolerance of each implementation.
  static constexpr double kMargin_m = 0.8, kMarginPerMetre = 0.07;
  // More than the distance between the rays of any sensor here.
  static constexpr double kCone_rad = 8 * std::numbers::pi / 180;

  test::ToyScene scene_;

 public:
  std::shared_ptr<const LidarScan> scan;
  CompensatedScan compensated;

 private:
  test::RaySearchOracle oracle_;
  std::vector<Vector3d> origins_0_, directions_0_;  // of each return's ray
};

/// The published check of points that have no normal.
std::vector<FreespaceVerdict> published(const std::vector<Vector3d>& queries, const CompensatedScan& scan) {
  CompensatedScan points;
  points.points_0 = queries;
  const PreparedScan prepared = {points, NearestNeighbours(queries),
                                 std::vector<Eigen::Vector3f>(queries.size(), Eigen::Vector3f::Zero())};
  std::vector<std::int32_t> all;
  for (std::size_t i = 0; i < queries.size(); ++i) all.push_back(static_cast<std::int32_t>(i));
  return check_freespace(prepared, all, scan, 0.2, {});
}

struct FreespaceImplementations : testing::TestWithParam<Case> {};

TEST_P(FreespaceImplementations, AgreeWhereTheAnswerIsClear) {
  const Scene scene(GetParam());
  const std::vector<Vector3d> queries = scene.queries(400);
  std::vector<std::optional<FreespaceVerdict>> expected(queries.size());
  tbb::parallel_for(std::size_t{0}, queries.size(),
                    [&](std::size_t i) { expected[i] = scene.clear_verdict(queries[i]); });
  const RayImage image(scene.compensated);
  const FreespaceProbe probe(image, image.origin_0(), {});
  const std::vector<FreespaceVerdict> by_paper = published(queries, scene.compensated);
  int inside = 0, outside = 0, observed = 0;
  for (std::size_t i = 0; i < queries.size(); ++i) {
    if (!expected[i]) continue;
    SCOPED_TRACE(testing::Message() << "query " << queries[i].transpose());
    ++(expected[i] == FreespaceVerdict::inside ? inside : outside);
    float column = 0;
    for (const FreespaceVerdict verdict :
         {probe.verdict((queries[i] - image.origin_0()).cast<float>(), column), by_paper[i]}) {
      if (verdict == FreespaceVerdict::unobserved) continue;
      ++observed;
      EXPECT_EQ(verdict, *expected[i]);
    }
  }
  EXPECT_GT(inside, 30);
  EXPECT_GT(outside, 30);
  EXPECT_GT(observed, inside + outside) << "hardly tests all of them";
}

INSTANTIATE_TEST_SUITE_P(Sensors, FreespaceImplementations,
                         testing::Values(Case{"HDL-64E-S2", 0, 0}, Case{"HDL-64E-S2", 5, 0.5},
                                         Case{"VLP-16", 0, 0}, Case{"VLP-16", 3, -1}, Case{"OS1-64", 5, 1}),
                         [](const auto& instance) { return "Case" + std::to_string(instance.index); });

}  // namespace MAPLESS_FILE
}  // namespace mapless
