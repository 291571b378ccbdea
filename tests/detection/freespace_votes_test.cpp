#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "support/toy_scene.hpp"
#include <mapless/detection/freespace_votes.hpp>

namespace mapless {
namespace {

using Eigen::Vector3d;

test::ToyBody wall_at(double x) { return test::toy_box({x + 0.5, 0, 0}, {0.5, 40, 40}); }

CompensatedScan cast(const test::ToyScene& scene, int number = 0) {
  return compensate(test::cast_scan(scene, number).scan, *scene.trajectory);
}

test::ToyScene standing(const test::ToyWorld& world, const char* sensor = "HDL-64E-S3") {
  test::ToyScene scene;
  scene.model = std::make_shared<const LidarModel>(named_model(sensor));
  scene.trajectory = std::make_shared<StationaryTrajectory>();
  scene.world = world;
  return scene;
}

/// Points well within all the walls, as no wall reaches round the sensor.
bool is_ahead(const CompensatedScan& scan, std::size_t i) {
  const Vector3d& p = scan.points_0[i];
  return std::abs(p.y()) < 0.5 * p.x();
}

struct Expected {
  int earlier, later;
  bool seen_through, surface_seen;
};

void expect_votes(double query_at, const std::vector<double>& earlier_at, double later_at,
                  const Expected& expected) {
  SCOPED_TRACE(testing::Message() << "wall at " << query_at);
  const CompensatedScan query = cast(standing({wall_at(query_at)}));
  std::vector<RayImage> images;
  for (const double x : earlier_at) images.emplace_back(cast(standing({wall_at(x)})));
  std::vector<const RayImage*> earlier;
  for (const RayImage& image : images) earlier.push_back(&image);
  const RayImage later(cast(standing({wall_at(later_at)})));
  const auto votes =
      collect_votes(*query.scan, local_points(query), earlier, later_at > 0 ? &later : nullptr, {});
  ASSERT_EQ(votes.size(), query.points_0.size());
  std::size_t ahead = 0, right = 0;
  for (std::size_t i = 0; i < votes.size(); ++i) {
    if (!is_ahead(query, i)) continue;
    ++ahead;
    right += votes[i].earlier == expected.earlier && votes[i].later == expected.later &&
             votes[i].seen_through == expected.seen_through && votes[i].surface_seen == expected.surface_seen;
  }
  EXPECT_GT(ahead, 5000u);
  EXPECT_EQ(right, ahead);
}

// A wall at 7 m: seen through by scans that saw it at 10 m, hidden from one that saw it at 5 m, a surface for
// one that saw it at 7 m.
TEST(CollectVotes, AddsUpWhatEveryScanSays) {
  expect_votes(7, {10, 5, 10}, 7, {2, -1, true, true});
  expect_votes(7, {7, 7, 10}, 10, {-1, 1, true, true});
  expect_votes(7, {5, 5, 5}, 5, {0, 0, false, false});
  expect_votes(7, {10, 12, 14}, 0, {3, 0, true, false});
  expect_votes(7, {7, 7.1, 6.9}, 7, {-3, -1, false, true});
  expect_votes(7, {}, 10, {0, 1, true, false});
  expect_votes(7, {}, 0, {0, 0, false, false});
}

/// The same without leaving any point out.
std::vector<PointVotes> ask_every_point(const LocalPoints& points,
                                        const std::vector<const RayImage*>& earlier, const RayImage* later,
                                        const VotingParameters& parameters) {
  std::vector<PointVotes> votes(points.points.size());
  std::vector<const RayImage*> all = earlier;
  if (later != nullptr) all.push_back(later);
  for (std::size_t k = 0; k < all.size(); ++k) {
    const FreespaceProbe probe(*all[k], points.origin_0, parameters);
    for (std::size_t i = 0; i < votes.size(); ++i) {
      float column = 0;
      const FreespaceVerdict verdict = probe.ask(points.points[i], column);
      const int vote =
          verdict == FreespaceVerdict::inside ? 1 : (verdict == FreespaceVerdict::border ? -1 : 0);
      auto& sum = k < earlier.size() ? votes[i].earlier : votes[i].later;
      sum = static_cast<std::int8_t>(sum + vote);
      votes[i].seen_through = votes[i].seen_through || vote > 0;
      votes[i].surface_seen = votes[i].surface_seen || vote < 0;
    }
  }
  return votes;
}

bool same(const PointVotes& a, const PointVotes& b) {
  return a.earlier == b.earlier && a.later == b.later && a.seen_through == b.seen_through &&
         a.surface_seen == b.surface_seen;
}

struct Scans {
  CompensatedScan query;
  std::vector<RayImage> images;

  Scans(const test::ToyScene& scene, int number, const std::vector<int>& others)
      : query(cast(scene, number)) {
    for (const int k : others) images.emplace_back(cast(scene, k));
  }
  [[nodiscard]] std::vector<const RayImage*> earlier() const {
    std::vector<const RayImage*> all;
    for (std::size_t k = 0; k + 1 < images.size(); ++k) all.push_back(&images[k]);
    return all;
  }
  [[nodiscard]] std::vector<PointVotes> votes() const {
    return collect_votes(*query.scan, local_points(query), earlier(), &images.back(), {});
  }
};

// In a room where nothing moves all points of a row between two that stand do so too; what scans that could
// not see a place do not vote differs here and there.
TEST(CollectVotes, OfSmoothSurfacesNothingIsLostByAskingOneInFour) {
  const Scans room(test::toy_room("HDL-64E-S3", test::drive(1, 0.3)), 9, {7, 5, 1, 10});
  const auto votes = room.votes();
  const auto all = ask_every_point(local_points(room.query), room.earlier(), &room.images.back(), {});
  std::size_t other = 0, other_sign = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    other += same(votes[i], all[i]) ? 0 : 1;
    other_sign += (votes[i].total() > 0) != (all[i].total() > 0) ? 1 : 0;
  }
  EXPECT_LE(other, all.size() / 50);
  EXPECT_LE(other_sign, all.size() / 10000);
}

// On the street: of what the votes call dynamic when every point is asked, next to nothing may be missed.
TEST(CollectVotes, OfWhatMovesNothingIsLostByAskingOneInFour) {
  const Scans street(test::toy_street("HDL-64E-S2"), 30, {28, 26, 22, 14, 31});
  const auto votes = street.votes();
  const auto all = ask_every_point(local_points(street.query), street.earlier(), &street.images.back(), {});
  std::size_t moves = 0, lost = 0, won = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    moves += all[i].total() > 0 ? 1 : 0;
    lost += all[i].total() > 0 && votes[i].total() <= 0 ? 1 : 0;
    won += all[i].total() <= 0 && votes[i].total() > 0 ? 1 : 0;
  }
  EXPECT_GT(moves, 1000u);
  EXPECT_LE(lost, moves / 200);
  EXPECT_LE(won, moves / 200);
}

// A pole that was not there before, of the width of one to three firings: between two points of a wall that
// agree.
TEST(CollectVotes, AsksAboutAThinThingInFrontOfAWall) {
  for (const double radius : {0.01, 0.02, 0.03}) {
    SCOPED_TRACE(radius);
    const test::ToyBody pole = test::toy_cylinder({7, 0, 0}, radius, 3);
    const CompensatedScan query = cast(standing({wall_at(10), pole}));
    const RayImage before(cast(standing({wall_at(10)})));
    const auto votes = collect_votes(*query.scan, local_points(query), {&before}, nullptr, {});
    int on_pole = 0;
    for (std::size_t i = 0; i < votes.size(); ++i) {
      if (!is_ahead(query, i)) continue;
      const bool pole_point = query.points_0[i].x() < 8;
      on_pole += pole_point ? 1 : 0;
      EXPECT_EQ(votes[i].total(), pole_point ? 1 : -1) << query.points_0[i].transpose();
    }
    EXPECT_GT(on_pole, 20);
  }
}

TEST(CollectVotes, ThreadsDoNotMatter) {
  const Scans street(test::toy_street("VLP-16"), 30, {28, 26, 22, 14, 31});
  const auto reference = street.votes();
  for (const std::size_t threads : {1u, 3u}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    const auto votes = street.votes();
    EXPECT_TRUE(std::equal(votes.begin(), votes.end(), reference.begin(), reference.end(), same));
  }
}

// Single precision about an origin near the points: as good at the far end of a country.
TEST(CollectVotes, FarFromTheWorldsOriginNothingChanges) {
  test::ToyScene room = test::toy_room("HDL-64E-S3", test::drive(2, 0.5));
  const Scans here(room, 3, {1, 4});
  Vector6d xi;
  xi << 600e3, -5400e3, 120, 0.1, -0.2, 2;
  room.trajectory = std::make_shared<test::MovedTrajectory>(room.trajectory, SE3::exp(xi), Duration());
  Scans there = here;
  there.query = compensate(here.query.scan, *room.trajectory);
  const LocalPoints local = local_points(there.query);
  for (std::size_t i = 0; i < local.points.size(); i += 101)
    EXPECT_LT((local.origin_0 + local.points[i].cast<double>() - there.query.points_0[i]).norm(), 1e-5);
}

TEST(CollectVotes, OfAnEmptyScanThereAreNone) {
  const CompensatedScan query = cast(standing({}));
  const RayImage image(cast(standing({wall_at(10)})));
  EXPECT_TRUE(collect_votes(*query.scan, local_points(query), {&image}, &image, {}).empty());
}

}  // namespace
}  // namespace mapless
