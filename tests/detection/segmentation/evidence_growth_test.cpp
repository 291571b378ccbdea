#include "detection/segmentation/evidence_growth.hpp"

#include <algorithm>
#include <random>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "oracle/evidence_growth_oracle.hpp"
#include "support/detection/evidence_image.hpp"
#include "support/small_scan.hpp"

namespace mapless {
namespace MAPLESS_FILE {

using test::points_of;
using test::small_scan;

class EvidenceImage : public test::EvidenceImage {};

constexpr int kColumns = test::kSmallColumns;

// 2 votes of its own and three times 2 of its neighbours are the 8 a seed needs; with 1 less it is removed.
TEST_F(EvidenceImage, ASeedNeedsTheVotesOfItsNeighbours) {
  set(2, 5, 2);
  set(1, 4, 2);
  set(3, 7, 2);
  set(2, 3, 2);
  EXPECT_EQ(filter()[at(2, 5)], FilterVerdict::kept);
  EXPECT_EQ(filter()[at(1, 4)], FilterVerdict::removed);  // (3, 7) is two lasers and three columns off
  set(2, 3, 1);
  EXPECT_EQ(filter()[at(2, 5)], FilterVerdict::removed);
  votes_[at(2, 3)].future = 1;
  EXPECT_EQ(filter()[at(2, 5)], FilterVerdict::kept);
}

TEST_F(EvidenceImage, NegativeVotesOfNeighboursCount) {
  for (int c = 3; c <= 7; ++c) set(2, c, 6);
  EXPECT_EQ(filter()[at(2, 5)], FilterVerdict::kept);
  for (int c = 3; c <= 7; ++c) {
    set(1, c, -3);
    set(3, c, -2);
  }
  EXPECT_EQ(filter()[at(2, 5)], FilterVerdict::removed);  // 30 - 25
}

TEST_F(EvidenceImage, ASinglePointIsRemoved) {
  set(2, 5, 6);
  EXPECT_EQ(filter()[at(2, 5)], FilterVerdict::removed);
  set(2, 6, 6);
  EXPECT_EQ(filter()[at(2, 5)], FilterVerdict::kept);
  parameters_.link_m = 0.1;  // 15 degrees at 5 m are 1.3 m
  parameters_.link_per_m = parameters_.link_spacings = 0;
  EXPECT_EQ(filter()[at(2, 5)], FilterVerdict::removed);
}

TEST_F(EvidenceImage, IsNotEvaluatedWithoutPositiveVotes) {
  set(2, 5, -1);
  set(2, 6, 0);
  for (int c = 7; c < 10; ++c) set(2, c, 6);
  EXPECT_EQ(filter()[at(2, 5)], FilterVerdict::not_evaluated);
  EXPECT_EQ(filter()[at(2, 6)], FilterVerdict::not_evaluated);
}

TEST_F(EvidenceImage, WrapsAtTheSeamAndEndsAboveAndBelow) {
  set(0, 0, 4);
  set(0, kColumns - 2, 4);
  EXPECT_EQ(filter()[at(0, 0)], FilterVerdict::kept);
  set(0, kColumns - 2, 0);
  set(4, 0, 4);
  EXPECT_EQ(filter()[at(0, 0)], FilterVerdict::removed);
}

TEST_F(EvidenceImage, NumbersObjectsByTheirFirstPointAndDropsSmallClusters) {
  for (int c : {14, 15, 16}) set(0, c, 3);  // first of all
  for (int c : {4, 5, 6}) set(1, c, 3);
  for (int c : {20, 22}) set(4, c, 3);  // two seeds only
  const EvidenceGrowthResult result = grow();
  EXPECT_EQ(result.objects, 2);
  EXPECT_EQ(result.object[at(0, 15)], 1);
  EXPECT_EQ(result.object[at(1, 6)], 2);
  EXPECT_EQ(result.verdict[at(4, 20)], GrowthVerdict::too_small);
  EXPECT_EQ(result.object[at(4, 20)], 0);
  parameters_.min_seeds = 2;
  EXPECT_EQ(grow().objects, 3);
}

TEST_F(EvidenceImage, GrowsOverPointsThatAnyScanSawThrough) {
  for (int c : {4, 5, 6}) set(2, c, 3);
  see_through(2, 9);
  see_through(2, 13);
  see_through(2, 18);  // five columns from the next: out of the window
  const EvidenceGrowthResult result = grow();
  EXPECT_EQ(result.verdict[at(2, 9)], GrowthVerdict::grown);
  EXPECT_EQ(result.verdict[at(2, 13)], GrowthVerdict::grown);
  EXPECT_EQ(result.verdict[at(2, 18)], GrowthVerdict::not_reached);
  EXPECT_EQ(result.verdict[at(2, 7)], GrowthVerdict::not_reached);
  EXPECT_EQ(result.objects, 1);
  parameters_.grow = false;
  EXPECT_EQ(grow().verdict[at(2, 9)], GrowthVerdict::not_reached);
}

// A point whose occluder has left is reached only if its votes sum above 0.
TEST_F(EvidenceImage, GrowsOverPointsWithADepartedOccluderByTheirVotes) {
  std::vector<FilterVerdict> seeds(votes_.size(), FilterVerdict::not_evaluated);
  for (int c : {4, 5, 6}) {
    set(2, c, 3);
    seeds[at(2, c)] = FilterVerdict::kept;
  }
  votes_[at(2, 9)].occluder_left = votes_[at(2, 10)].occluder_left = true;
  votes_[at(2, 9)].past = 2;
  votes_[at(2, 10)] = {2, -2, false, true, true, true};
  const EvidenceGrowthResult result = grow_evidence(scan_, points_, votes_, seeds, parameters_);
  EXPECT_EQ(result.verdict[at(2, 9)], GrowthVerdict::grown);
  EXPECT_EQ(result.verdict[at(2, 10)], GrowthVerdict::not_reached);
}

// Growth that meets another cluster joins both into one object, also a cluster that was too small.
TEST_F(EvidenceImage, LinkedPointsAreOneObject) {
  for (int c : {2, 3, 4, 12, 13, 14}) set(2, c, 3);
  EXPECT_EQ(grow().objects, 2);
  see_through(2, 8);
  EXPECT_EQ(grow().objects, 1);
  for (int c : {12, 13}) set(2, c, 0);
  const EvidenceGrowthResult result = grow();
  EXPECT_EQ(result.verdict[at(2, 8)], GrowthVerdict::grown);
  EXPECT_EQ(result.verdict[at(2, 14)], GrowthVerdict::too_small);  // six columns off
  see_through(2, 11);
  EXPECT_EQ(grow().verdict[at(2, 14)], GrowthVerdict::grown);
}

// Five of the 14 neighbours fill a point of at least -12 votes; the second round starts from filled points.
TEST_F(EvidenceImage, FillsHolesAndRims) {
  for (int c : {4, 5, 6}) set(2, c, 3);
  for (int c : {5, 6}) set(3, c, 3);
  EXPECT_EQ(grow().verdict[at(2, 7)], GrowthVerdict::not_reached);  // (2, 5), (2, 6), (3, 5), (3, 6)
  set(3, 4, 3);
  set(3, 7, 3);
  set(2, 5, -12);
  EXPECT_EQ(grow().verdict[at(2, 5)], GrowthVerdict::grown);
  set(2, 5, -13);
  EXPECT_EQ(grow().verdict[at(2, 5)], GrowthVerdict::not_reached);
  set(2, 5, 3);
  // (2, 7) has (2, 5), (2, 6), (3, 5), (3, 6), (3, 7); (2, 8) has but (2, 6), (3, 6), (3, 7) and (2, 7).
  EXPECT_EQ(grow().verdict[at(2, 7)], GrowthVerdict::grown);
  EXPECT_EQ(grow().object[at(2, 7)], 1);
  EXPECT_EQ(grow().verdict[at(2, 9)], GrowthVerdict::not_reached);
  parameters_.grow = false;
  EXPECT_EQ(grow().verdict[at(2, 7)], GrowthVerdict::not_reached);
}

// At 5 m lasers are 0.05 m apart, a hundredth of a radian. (2, 9) is beside (2, 8), too, but that is a rim.
TEST_F(EvidenceImage, RimsAreFilledFromOneDistantLaser) {
  parameters_.link_per_m = 20;  // all are linked
  for (int c = 4; c <= 12; ++c) set(3, c, 3);
  parameters_.link_m = 0.051;
  EXPECT_TRUE(grow().rims.empty());
  parameters_.link_m = 0.049;
  for (const int c : {8, 9}) EXPECT_THAT(grow().rims, testing::Contains(at(2, c)));
  for (const auto& [row, column] : {std::pair{1, 8}, {2, 10}}) {  // in the row beyond, or its own
    set(row, column, 3);
    for (const int c : {8, 9}) EXPECT_THAT(grow().rims, testing::Not(testing::Contains(at(2, c))));
    set(row, column, 0);
  }
}

// A straight end advances by one column per round in its middle: two rounds, and six more over points of at
// least -4 votes.
TEST_F(EvidenceImage, FillsFartherOverTangentialSurfaces) {
  for (const int votes : {-4, -5}) {
    SCOPED_TRACE(votes);
    for (int r = 0; r < 5; ++r) {
      for (int c = 0; c < 20; ++c) set(r, c, c < 6 ? 3 : votes);
    }
    EXPECT_EQ(grow().object[at(2, 7)], 1);
    EXPECT_EQ(grow().object[at(2, 8)], votes == -4 ? 1 : 0);
    EXPECT_EQ(grow().object[at(2, 10)], votes == -4 ? 1 : 0);
    EXPECT_EQ(grow().object[at(2, 14)], 0);
  }
}

// Two linked points with votes above 0, too few for an object; one alone and points of 0 votes are none.
TEST_F(EvidenceImage, TwoLinkedPointsWithVotesAreAFaintCluster) {
  for (int c : {4, 5, 6}) set(2, c, 3);  // an object
  set(2, 16, 1);
  set(3, 17, 1);
  votes_[at(2, 18)].seen_through = true;  // and one that saw a surface: 0 votes
  set(0, 22, 1);
  const EvidenceGrowthResult result = grow();
  EXPECT_EQ(result.objects, 1);
  ASSERT_EQ(result.faint.size(), 1u);
  EXPECT_EQ(
      std::set<std::int32_t>(result.faint[0].begin(), result.faint[0].end()),
      (std::set<std::int32_t>{static_cast<std::int32_t>(at(2, 16)), static_cast<std::int32_t>(at(3, 17))}));
}

// Of two points at distance d one was seen through recently: a displacement of d / 2; both: of d.
TEST_F(EvidenceImage, EstimatesTheDisplacementOfAnObject) {
  parameters_.grow = false;  // which would fill its rims
  parameters_.min_seeds = 2;
  set(1, 4, 3);
  set(1, 5, 3);
  make_old(1, 5);
  const float d = (points_.points[at(1, 4)] - points_.points[at(1, 5)]).norm();
  ASSERT_EQ(grow().evidence.size(), 1u);
  EXPECT_NEAR(grow().evidence[0].displacement_m, d / 2, 1e-5);
  make_old(1, 4);
  EXPECT_EQ(grow().evidence[0].displacement_m, 0);
  votes_[at(1, 4)].recently_free = votes_[at(1, 5)].recently_free = true;
  EXPECT_NEAR(grow().evidence[0].displacement_m, d, 1e-5);
}

// A ten times smaller object with the same share has a tenth of the displacement.
TEST_F(EvidenceImage, DisplacementIsProportionalToSize) {
  parameters_.grow = false;
  for (int c = 2; c < 12; ++c) {
    set(0, c, 3);
    if (c > 2) make_old(0, c);
  }
  const float displacement_m = grow().evidence.at(0).displacement_m;
  EXPECT_GT(displacement_m, 0);
  for (Eigen::Vector3f& p : points_.points) p *= 0.1F;
  EXPECT_NEAR(grow().evidence.at(0).displacement_m, 0.1F * displacement_m, 1e-5);
}

// Grown and filled points count with the rest of their object; there is one element per object, in order.
TEST_F(EvidenceImage, EveryObjectHasItsOwnDisplacement) {
  for (int c : {2, 3, 4}) {
    set(0, c, 3);
    make_old(0, c);
  }
  for (int c : {12, 13, 14}) set(0, c, 3);
  EvidenceGrowthResult result = grow();
  ASSERT_EQ(result.evidence.size(), 2u);
  EXPECT_EQ(result.evidence[0].displacement_m, 0);
  EXPECT_GT(result.evidence[1].displacement_m, 0);
  see_through(1, 5);  // one of four, linked to the first
  EXPECT_GT(grow().evidence.at(0).displacement_m, 0);
}

// The faint clusters one and two columns from the object are 1.3 and 2.6 m away, one at three columns 3.8 m.
TEST_F(EvidenceImage, FaintClustersWithinThreeMetresAreClutter) {
  parameters_.link_m = 0.2;
  parameters_.link_spacings = 0;
  parameters_.grow = false;
  parameters_.min_seeds = 5;
  for (int l : {0, 1, 2, 3, 4}) set(l, 4, 3);
  for (int c : {3, 6, 1}) {
    set(2, c, 1);
    set(3, c, 1);
  }
  const EvidenceGrowthResult result = grow();
  ASSERT_EQ(result.objects, 1);
  ASSERT_EQ(result.faint.size(), 3u);
  EXPECT_EQ(result.evidence[0].clutter, 2);
}

// Three rows of seven points: five of 21 that no scan saw through are a fifth, four are less. Two rows are
// too few.
TEST_F(EvidenceImage, ABodyNotSeenThroughEverywhereIsRigid) {
  parameters_.grow = false;
  const auto body = [&](int rows, int hidden) {
    for (int r = 0; r < 3; ++r) {
      for (int c = 4; c < 11; ++c) set(r, c, r < rows ? 3 : 0);
    }
    for (int n = 0; n < hidden; ++n) votes_[at(n % 2, 5 + n / 2)].seen_through = false;
    return grow().evidence.at(0).body;
  };
  EXPECT_EQ(body(3, 5), Body::rigid);
  EXPECT_EQ(body(3, 4), Body::unclear);
  EXPECT_EQ(body(2, 8), Body::unclear);
}

// Where two of ten points stood before, more than a tenth of them, the body did; one may have come between.
// What only recent scans saw is no sign of it, and part of a rigid body may lie where something else stood.
TEST_F(EvidenceImage, ABodyOfWhichMoreThanATenthStoodBeforeIsStanding) {
  parameters_.grow = false;
  const auto body = [&](int stood) {
    for (int c = 4; c < 14; ++c) {
      set(1, c, 3);
      votes_[at(1, c)].surface_seen = true;
      votes_[at(1, c)].stood_before = c < 4 + stood;
    }
    return grow().evidence.at(0).body;
  };
  EXPECT_EQ(body(2), Body::standing);
  EXPECT_EQ(body(1), Body::unclear);
  for (const int r : {0, 2}) {
    for (int c = 4; c < 14; ++c) {
      set(r, c, 3);
      votes_[at(r, c)].seen_through = false;
    }
  }
  EXPECT_EQ(body(10), Body::rigid);
}

TEST_F(EvidenceImage, SumsTheVotesOfEveryObject) {
  parameters_.grow = false;  // which would add points
  for (int c : {2, 3, 4}) set(0, c, 3);
  for (int c : {12, 13, 14}) set(0, c, 5);
  votes_[at(0, 13)].future = -1;
  const EvidenceGrowthResult result = grow();
  ASSERT_EQ(result.evidence.size(), 2u);
  EXPECT_EQ(result.evidence[0].votes, 9);
  EXPECT_EQ(result.evidence[1].votes, 14);
}

TEST_F(EvidenceImage, FindsNoObjectWithoutPointsOrSeeds) {
  EXPECT_EQ(grow().objects, 0);
  const LidarScan empty = small_scan({0, 0}, 5, std::vector<char>(2 * kColumns, 1));
  EXPECT_TRUE(filter_evidence(empty, points_of(empty), {}, parameters_).empty());
  EXPECT_EQ(grow_evidence(empty, points_of(empty), {}, {}, parameters_).objects, 0);
}

struct RandomImage {
  LidarScan scan;
  LocalPoints points;
  std::vector<PointEvidence> votes;
};

/// Points at ranges of 3 to 8 m that jump now and then, votes in runs, returns missing.
RandomImage random_image(std::mt19937_64& random) {
  const std::vector<double> offsets = {0.2, -3.1, 2.4, 5.3, -0.4, 1.1};
  std::vector<char> missing(offsets.size() * kColumns);
  for (char& m : missing) m = random() % 8 == 0 ? 1 : 0;
  RandomImage image{small_scan(offsets, 5, missing), {}, {}};
  float range = 5;
  int votes = 0;
  for (LidarReturn& r : image.scan.returns) {
    if (random() % 6 == 0) range = 3 + 0.5F * static_cast<float>(random() % 11);
    if (random() % 4 == 0) votes = static_cast<int>(random() % 9) * 3 - 12;
    r.position_v *= range / r.range_m;
    r.range_m = range;
    const bool both = random() % 3 == 0;
    const int later = static_cast<int>(random() % 3) * 4 - 4;
    const bool through = both || ((votes > 0 || later > 0) && random() % 4 != 0);
    image.votes.push_back({static_cast<std::int16_t>(votes), static_cast<std::int16_t>(later), through,
                           votes < 0 || later < 0 || both, through && random() % 3 == 0});
    image.votes.back().stood_before = votes < 0 && random() % 2 == 0;
  }
  image.points = points_of(image.scan);
  return image;
}

TEST(EvidenceGrowth, AgreesWithExhaustiveSearch) {
  int kept = 0, grown = 0, objects = 0;
  std::set<Body> bodies;
  for (unsigned seed = 0; seed < 150; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937_64 random(seed);
    RandomImage image = random_image(random);
    if (seed % 2 == 1) test::raise_by_60_degrees(image.scan);
    VotingParameters parameters;
    parameters.link_m = 0.4 + 0.4 * static_cast<double>(seed % 5);
    parameters.link_per_m = seed % 2 == 0 ? 0.0 : 0.1;
    parameters.link_spacings = seed % 3 == 0 ? 0.0 : 0.5;
    parameters.seed_score = 6 + 3 * static_cast<int>(seed % 7);
    parameters.min_seeds = 1 + static_cast<int>(seed % 4);
    parameters.grow = seed % 9 != 0;
    const test::EvidenceGrowthOracle oracle(image.scan, image.points, parameters);
    const auto seeds = filter_evidence(image.scan, image.points, image.votes, parameters);
    ASSERT_EQ(seeds, oracle.filter(image.votes));
    const EvidenceGrowthResult expected = oracle.grow(image.votes, seeds);
    const EvidenceGrowthResult result =
        grow_evidence(image.scan, image.points, image.votes, seeds, parameters);
    ASSERT_EQ(result.verdict, expected.verdict);
    ASSERT_EQ(result.object, expected.object);
    ASSERT_EQ(result.objects, expected.objects);
    ASSERT_EQ(result.evidence.size(), expected.evidence.size());
    for (std::size_t n = 0; n < expected.evidence.size(); ++n) {
      ASSERT_NEAR(result.evidence[n].displacement_m, expected.evidence[n].displacement_m, 1e-4);
      ASSERT_EQ(result.evidence[n].votes, expected.evidence[n].votes);
      ASSERT_EQ(result.evidence[n].body, expected.evidence[n].body);
      bodies.insert(result.evidence[n].body);
    }
    kept += static_cast<int>(std::count(seeds.begin(), seeds.end(), FilterVerdict::kept));
    grown += static_cast<int>(std::count(result.verdict.begin(), result.verdict.end(), GrowthVerdict::grown));
    objects += result.objects;
  }
  EXPECT_GT(kept, 500);
  EXPECT_GT(grown, 400);
  EXPECT_GT(objects, 200);
  EXPECT_EQ(bodies.size(), 4u);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
