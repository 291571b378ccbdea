// Not every point is queried: points between neighbours that agree get their evidence. The oracle queries
// all.
#include <algorithm>
#include <utility>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "detection/evidence/collect_evidence.hpp"
#include "oracle/evidence_oracle.hpp"
#include "support/detection/standing_scene.hpp"
#include "support/local_points.hpp"

namespace mapless {
namespace MAPLESS_FILE {

using test::cast;
using test::is_ahead;
using test::local_points;
using test::references;
using test::standing;
using test::wall_at;

struct Scans {
  CompensatedScan query;
  RayImage own = RayImage(query);
  std::vector<RayImage> images;
  std::vector<int> gaps;

  Scans(const test::ToyScene& scene, int number, const std::vector<int>& others)
      : query(cast(scene, number)) {
    for (const int k : others) {
      images.emplace_back(cast(scene, k));
      gaps.push_back(number - k);
    }
  }
  [[nodiscard]] std::vector<PointEvidence> votes() const {
    return collect_evidence(*query.scan, local_points(query), references(images, gaps), own, {});
  }
  [[nodiscard]] std::vector<PointEvidence> all_votes() const {
    return test::query_every_point(*query.scan, local_points(query), references(images, gaps), own, {});
  }
};

// In a static room all points between two static ones are static too, in a row or between two rows; the votes
// of scans that could not observe a point differ here and there.
TEST(ScanlineSampler, LosesLittleOnSmoothSurfaces) {
  const Scans room(test::toy_room("HDL-64E-S3", test::drive(1, 0.3)), 9, {7, 5, 1, 10});
  const auto votes = room.votes();
  const auto all = room.all_votes();
  std::size_t other = 0, lost = 0, won = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    other += votes[i] == all[i] ? 0 : 1;
    lost += votes[i].total() <= 0 && all[i].total() > 0 ? 1 : 0;
    won += votes[i].total() > 0 && all[i].total() <= 0 ? 1 : 0;
  }
  EXPECT_LE(other, all.size() / 12);
  EXPECT_LE(lost, all.size() / 2000);  // border effects, which one scan that saw through decides
  EXPECT_LE(won, all.size() / 3000);
}

// On the street: of the points with positive evidence when every point is queried, next to none may be lost.
// A point on the line between two dynamic ones is dynamic too, whatever its own rays observe. Of the points
// that no scan saw through more are lost: whether they were uncovered depends, point by point, on noise.
TEST(ScanlineSampler, LosesLittleOfWhatMoves) {
  const Scans street(test::toy_street("HDL-64E-S2"), 30, {28, 26, 22, 14, 31});
  const auto votes = street.votes();
  const auto all = street.all_votes();
  std::size_t moves = 0, lost = 0, through = 0, lost_through = 0, won = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const bool is_lost = all[i].total() > 0 && votes[i].total() <= 0;
    moves += all[i].total() > 0 ? 1 : 0;
    lost += is_lost ? 1 : 0;
    through += all[i].total() > 0 && all[i].seen_through ? 1 : 0;
    lost_through += is_lost && all[i].seen_through ? 1 : 0;
    won += all[i].total() <= 0 && votes[i].total() > 0 ? 1 : 0;
  }
  EXPECT_GT(moves, 1000u);
  EXPECT_LE(lost_through, through / 60);
  EXPECT_LE(lost, moves / 20);
  EXPECT_LE(won, moves / 30);
}

// A pole that was not there before, of the width of one to three firings: between two points of a wall that
// agree.
TEST(ScanlineSampler, QueriesAThinPoleInFrontOfAWall) {
  for (const double radius : {0.01, 0.02, 0.03}) {
    SCOPED_TRACE(radius);
    const test::ToyBody pole = test::toy_cylinder({7, 0, 0}, radius, 3);
    const CompensatedScan query = cast(standing({wall_at(10), pole}));
    const RayImage before(cast(standing({wall_at(10)})));
    const auto votes =
        collect_evidence(*query.scan, local_points(query), {{&before, 2}}, RayImage(query), {});
    int on_pole = 0;
    for (std::size_t i = 0; i < votes.size(); ++i) {
      if (!is_ahead(query, i)) continue;
      const bool pole_point = query.points_0[i].x() < 8;
      on_pole += pole_point ? 1 : 0;
      EXPECT_EQ(votes[i].total(), pole_point ? 4 : -1) << query.points_0[i].transpose();
    }
    EXPECT_GT(on_pole, 20);
  }
}

// A bar that one laser hits, or two: between rows of a wall that an old scan votes static.
TEST(ScanlineSampler, QueriesAThinBarBetweenTwoLasers) {
  const RayImage before(cast(standing({wall_at(10)})));
  int on_bar = 0;
  for (double z = -0.6; z < 0; z += 0.043) {
    SCOPED_TRACE(z);
    const CompensatedScan query = cast(standing({wall_at(10), test::toy_box({7, 0, z}, {0.02, 1.5, 0.02})}));
    const auto votes =
        collect_evidence(*query.scan, local_points(query), {{&before, 16}}, RayImage(query), {});
    for (std::size_t i = 0; i < votes.size(); ++i) {
      if (!is_ahead(query, i)) continue;
      const bool bar_point = query.points_0[i].x() < 8;
      on_bar += bar_point ? 1 : 0;
      EXPECT_EQ(votes[i].total(), bar_point ? 4 : -4) << query.points_0[i].transpose();
    }
  }
  EXPECT_GT(on_bar, 500);
}

TEST(ScanlineSampler, ThreadsDoNotMatter) {
  const Scans street(test::toy_street("VLP-16"), 30, {28, 26, 22, 14, 31});
  const auto reference = street.votes();
  for (const std::size_t threads : {1u, 3u}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    const auto votes = street.votes();
    EXPECT_TRUE(std::equal(votes.begin(), votes.end(), reference.begin(), reference.end()));
  }
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
