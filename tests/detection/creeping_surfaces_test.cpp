#include "detection/creeping_surfaces.hpp"

#include <deque>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "support/local_points.hpp"
#include "support/toy_scene.hpp"

namespace mapless {
namespace {

using Eigen::Vector3d;

constexpr std::uint16_t kBox = 7;

// A box of 2 x 2 x 1.6 m on the ground, which comes nearer: its front is 7 m off in scan 8.
test::ToyScene scene_of(double speed_mps, double x_at_zero) {
  test::ToyScene scene;
  scene.model = std::make_shared<const LidarModel>(named_model("HDL-64E-S3"));
  scene.trajectory = std::make_shared<StationaryTrajectory>();
  scene.world = {test::toy_ground(-1.7), test::toy_box({x_at_zero, 0.6, -0.9}, {1, 1, 0.8}, 0.4)};
  scene.world[1].velocity_0 = {-speed_mps, 0, 0};
  scene.world[1].object = kBox;
  scene.range_noise_m = 0.02;
  return scene;
}

class CreepingBox : public testing::Test {
 protected:
  static constexpr int kQuery = 8;

  void see(double speed_mps, double speed_later_mps) {
    const double x = 8 + speed_mps * 0.1 * kQuery;
    const test::ToyScene scene = scene_of(speed_mps, x);
    for (const int gap : {1, 2, 3, 4, 6, 8}) ask(scene, gap);
    // At the query's place in the middle of that scan, whatever the speed afterwards.
    ask(scene_of(speed_later_mps, 8 + speed_later_mps * 0.1 * kQuery), -1);
    query_ = compensate(test::cast_scan(scene, kQuery).scan, *scene.trajectory);
    votes_.assign(query_.scan->returns.size(), {});
  }

  void ask(const test::ToyScene& scene, int gap) {
    images_.emplace_back(compensate(test::cast_scan(scene, kQuery - gap).scan, *scene.trajectory));
    asked_.push_back({&images_.back(), gap});
  }

  void vote() { vote_for_creeping(*query_.scan, test::local_points(query_), asked_, {}, votes_); }

  // Above the ground by more than the noise.
  [[nodiscard]] bool is_box(std::size_t i) const { return query_.points_0[i].z() > -1.6; }
  [[nodiscard]] double share_found(bool box) const {
    std::size_t all = 0, found = 0;
    for (std::size_t i = 0; i < votes_.size(); ++i) {
      if (is_box(i) != box) continue;
      ++all;
      found += votes_[i].total() >= kSeenThroughVotes && votes_[i].recently ? 1 : 0;
    }
    return static_cast<double>(found) / static_cast<double>(all);
  }

  std::deque<RayImage> images_;  // elements stay where they are
  std::vector<AskedScan> asked_;
  CompensatedScan query_;
  std::vector<PointVotes> votes_;
};

// 0.4 m/s: since the scan 4 before it went 0.16 m, less than the 0.2 m within which a ray tells of a surface.
TEST_F(CreepingBox, IsFoundWithItsSidesAndWithoutTheGround) {
  see(0.4, 0.4);
  vote();
  EXPECT_GT(share_found(true), 0.8);
  EXPECT_LT(share_found(false), 0.001);
}

TEST_F(CreepingBox, IsFoundWhereItGoesAway) {
  see(-0.4, -0.4);
  vote();
  EXPECT_GT(share_found(true), 0.8);
  EXPECT_LT(share_found(false), 0.001);
}

TEST_F(CreepingBox, ThatStandsIsNotFound) {
  see(0, 0);
  vote();
  EXPECT_EQ(share_found(true), 0);
  EXPECT_EQ(share_found(false), 0);
}

// 0.08 m/s make 2.4 cm in the 0.3 s since the nearest scan that has to tell: less than 3 cm.
TEST_F(CreepingBox, ThatHardlyMovesIsNotFound) {
  see(0.08, 0.08);
  vote();
  EXPECT_EQ(share_found(true), 0);
}

// What hid behind an edge seems to have come nearer too, but stays where it is.
TEST_F(CreepingBox, ThatStandsInTheLaterScanIsNotFound) {
  see(0.4, 0);
  vote();
  EXPECT_EQ(share_found(true), 0);
}

TEST_F(CreepingBox, IsNotFoundWithoutALaterScan) {
  see(0.4, 0.4);
  asked_.pop_back();
  vote();
  EXPECT_EQ(share_found(true), 0);
}

TEST_F(CreepingBox, ThatRaysFoundKeepsItsVotes) {
  see(0.4, 0.4);
  for (PointVotes& v : votes_) v = {.earlier = 2, .seen_through = true};
  vote();
  for (const PointVotes& v : votes_) ASSERT_EQ(v.total(), 2);
}

// Three scans, seconds ago and a moment ago, saw a surface in its place: 4 + 3 + 2 votes.
TEST_F(CreepingBox, ThatWasThereSecondsAgoStands) {
  see(0.4, 0.4);
  for (PointVotes& v : votes_) v = {.earlier = -9, .surface_seen = true};
  vote();
  for (const PointVotes& v : votes_) ASSERT_EQ(v.total(), -9);
}

TEST_F(CreepingBox, HasVotesThatOutweighTheLaterScans) {
  see(0.4, 0.4);
  for (PointVotes& v : votes_) v = {.earlier = -3, .later = -1, .surface_seen = true};
  vote();
  EXPECT_GT(share_found(true), 0.8);
  for (const PointVotes& v : votes_) ASSERT_TRUE(v.total() == -4 || v.total() == kSeenThroughVotes);
}

}  // namespace
}  // namespace mapless
