#include "detection/tracking/standing_test.hpp"

#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "support/toy_scene.hpp"
#include <mapless/geometry/compensated_scan.hpp>

namespace mapless {
namespace MAPLESS_FILE {

using Eigen::Vector3d;

constexpr int kScan = 8;

// A box of one metre, 4 m ahead of a sensor that drives at `sensor_mps`, and 1 m to its right, at scan kScan.
test::ToyScene room_with_box(const Vector3d& velocity_0, double sensor_mps = 0) {
  auto room = test::toy_room("OS1-64", test::drive(sensor_mps, 0));
  const double then_s = 0.1 * kScan;
  room.world.push_back(
      test::toy_box(Vector3d(4 + sensor_mps * then_s, -1, 0) - then_s * velocity_0, {0.5, 0.5, 0.8}));
  room.world.back().velocity_0 = velocity_0;
  room.world.back().object = 1;
  return room;
}

// In its place a ball of 0.4 m: unlike the sides of a box its surface shows motion in every direction.
test::ToyScene room_with_ball(const Vector3d& velocity_0) {
  auto room = test::toy_room("OS1-64", test::drive(0, 0));
  room.world.push_back(test::toy_sphere(Vector3d(3, -1, 0) - 0.1 * kScan * velocity_0, 0.4));
  room.world.back().velocity_0 = velocity_0;
  room.world.back().object = 1;
  return room;
}

// A test of the box in scan kScan, against these scans before and the next.
class TestOfBox {
 public:
  TestOfBox(const test::ToyScene& scene, const std::vector<int>& gaps) {
    const auto cast = test::cast_scan(scene, kScan);
    auto [compensated, points] = compensate_locally(cast.scan, *scene.trajectory);
    scan_ = compensated.scan;
    points_ = std::move(points);
    for (const int gap : gaps) {
      const auto other = compensate_locally(test::cast_scan(scene, kScan - gap).scan, *scene.trajectory);
      references_.push_back({std::make_shared<RayImage>(other.first), gap});
    }
    const test::ToyBody& box = scene.world.back();
    for (std::size_t i = 0; i < points_.points.size(); ++i) {
      const Vector3d p_0 = points_.origin_0 + points_.points[i].cast<double>();
      const Vector3d centre_0 = box.pose_at(scan_->time_of(scan_->returns[i])).translation();
      const Vector3d off = (p_0 - centre_0).cwiseAbs();
      if (off.x() < 0.6 && off.y() < 0.6 && off.z() < 0.75) box_.push_back(static_cast<std::int32_t>(i));
    }
  }
  [[nodiscard]] std::size_t returns() const { return box_.size(); }
  [[nodiscard]] bool stands(const Vector3d& velocity_0) const {
    return StandingTest(*scan_, points_, references_, {}).stands(box_, velocity_0, 0.1);
  }

 private:
  std::shared_ptr<const LidarScan> scan_;
  LocalPoints points_;
  std::vector<ReferenceRays> references_;
  std::vector<std::int32_t> box_;
};

const std::vector<int> kGaps = {1, 2, 3, 4, 6, 8, -1};

// Moved by 1 m/s, the box is off by 0.1 to 0.4 m where it was seen: along the rays more than the tolerance of
// 0.1 m, across them as much of a side of one metre.
TEST(StandingTest, ABoxThatStandsDoesNotMoveWhateverItsVelocity) {
  for (const double sensor_mps : {0.0, 2.0}) {
    SCOPED_TRACE(sensor_mps);
    const TestOfBox box(room_with_box(Vector3d::Zero(), sensor_mps), kGaps);
    ASSERT_GT(box.returns(), 500u);
    EXPECT_TRUE(box.stands({1, 0, 0}));
    EXPECT_TRUE(box.stands({0, 1, 0}));
    EXPECT_TRUE(box.stands({-3, 2, 0}));
  }
}

// Four scans before, it was 0.4 m nearer or farther, or 0.8 m to one side.
TEST(StandingTest, ABoxThatMovesDoesNotStand) {
  for (const Vector3d& v : {Vector3d(1, 0, 0), Vector3d(-1, 0, 0), Vector3d(0, 2, 0), Vector3d(0, -2, 0)}) {
    SCOPED_TRACE(v.transpose());
    const TestOfBox box(room_with_box(v), kGaps);
    ASSERT_GT(box.returns(), 500u);
    EXPECT_FALSE(box.stands(v));
    EXPECT_FALSE(box.stands(-v));  // a wrong velocity does not make it stand
  }
}

// Its side slides along itself: most of it is where it was, but nothing speaks against its velocity.
TEST(StandingTest, ASideThatSlidesAlongItselfDoesNotStand) {
  EXPECT_FALSE(TestOfBox(room_with_box({0, 1, 0}), kGaps).stands({0, 1, 0}));
}

// At 0.4 m/s it is 0.04 to 0.08 m off in the scans nearest to it, within the tolerance, and 0.16 m four scans
// before.
TEST(StandingTest, ASlowBoxWithAWrongVelocityDoesNotStand) {
  const TestOfBox box(room_with_box({-0.4, 0, 0}), kGaps);
  ASSERT_GT(box.returns(), 500u);
  EXPECT_FALSE(box.stands({-2, 0, 0}));
}

// What creeps counts as standing, whatever its track says: at 0.1 m/s the ball is 1 cm off in the scans
// beside this one, at 0.4 m/s 4 cm. Eight scans before, which would show 0.3 m/s, it was 8 cm off, and within
// the tolerance at most places of its surface in neither case, as a surface that slows down.
TEST(StandingTest, TheRaysMeasureASlowSurface) {
  for (const Vector3d& along : {Vector3d(1, 0, 0), Vector3d(0, 1, 0), Vector3d(-0.6, -0.8, 0)}) {
    SCOPED_TRACE(along.transpose());
    const TestOfBox slow(room_with_ball(0.1 * along), kGaps);
    ASSERT_GT(slow.returns(), 500u);
    EXPECT_TRUE(slow.stands(0.6 * along));
    EXPECT_TRUE(slow.stands(-along));
    EXPECT_TRUE(slow.stands(Vector3d::Zero()));
    const TestOfBox walks(room_with_ball(0.35 * along), kGaps);
    EXPECT_FALSE(walks.stands(0.6 * along));
    EXPECT_FALSE(walks.stands(-along));
  }
}

// Nobody stops from 4 m/s within the time over which a track is registered: the rays of the next scans do not
// tell what slides along itself from what stands. Without an older scan nothing else does.
TEST(StandingTest, TheRaysDoNotStopWhatIsFast) {
  const TestOfBox ball(room_with_ball(Vector3d::Zero()), {1, 2, -1});
  EXPECT_TRUE(ball.stands({0, 2, 0}));
  EXPECT_FALSE(ball.stands({0, 4, 0}));
}

TEST(StandingTest, NothingIsKnownToStandWithoutAScanThatWouldShowSlowMotion) {
  const auto scene = room_with_box(Vector3d::Zero());
  EXPECT_FALSE(TestOfBox(scene, {}).stands({1, 0, 0}));
  EXPECT_FALSE(TestOfBox(scene, {1, 2}).stands({1, 0, 0}));
  EXPECT_TRUE(TestOfBox(scene, {1, 2, 4}).stands({1, 0, 0}));  // needs no later scan
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
