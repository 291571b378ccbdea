#include "detection/tracking/completion/sliding_sides.hpp"

#include <cmath>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "support/toy_scene.hpp"
#include <mapless/geometry/compensated_scan.hpp>

namespace mapless {
namespace MAPLESS_FILE {

using Eigen::Vector3d;

constexpr int kScan = 12;
constexpr double kSide_m = 3;        // of the body, left of the sensor
constexpr double kHalfLength_m = 5;  // at scan kScan it reaches from -7 m to 3 m along x
constexpr double kFront_m = 3, kFrontLength_m = 1.5;
const std::vector<int> kGaps = {1, 2, 3, 4, 6, 8, 12, -1};

// A long box beside a sensor at rest in a room, at scan kScan at the same place whatever its velocity.
test::ToyScene room_with_bus(double speed_mps) {
  auto room = test::toy_room("OS1-64", test::drive(0, 0));
  room.world.push_back(test::toy_box({kFront_m - kHalfLength_m - 0.1 * kScan * speed_mps, kSide_m + 1, 0},
                                     {kHalfLength_m, 1, 1}));
  room.world.back().velocity_0 = {speed_mps, 0, 0};
  return room;
}

// Scan `number` as tracking has it: the foremost part of the box is an object, 1, that moves.
class Scan {
 public:
  Scan(const test::ToyScene& scene, int number, double speed_mps) {
    auto [compensated, points] = compensate_locally(test::cast_scan(scene, number).scan, *scene.trajectory);
    scan_ = compensated.scan;
    proposed_.points = std::move(points);
    proposed_.rays = std::make_shared<RayImage>(compensated);
    for (const int gap : kGaps) {
      const auto other = compensate_locally(test::cast_scan(scene, number - gap).scan, *scene.trajectory);
      proposed_.references.push_back({std::make_shared<RayImage>(other.first), gap});
    }
    proposed_.votes.resize(proposed_.points.points.size());
    const double end = kFront_m + 0.1 * (number - kScan) * speed_mps;
    for (const Eigen::Vector3f& p : proposed_.points.points) {
      const Vector3d p_0 = proposed_.points.origin_0 + p.cast<double>();
      const bool side = std::abs(p_0.y() - kSide_m) < 0.1 && std::abs(p_0.z()) < 1 && p_0.x() < end + 0.1;
      const bool front = side && p_0.x() > end - kFrontLength_m;
      object_.push_back(front ? 1 : 0);
      side_ += side && !front ? 1 : 0;
    }
  }
  // The scan that lies `gap` before this one is of another scene.
  void replace_reference(int gap, const test::ToyScene& scene, int number) {
    for (ReferenceRays& r : proposed_.references) {
      if (r.gap != gap) continue;
      const auto other = compensate_locally(test::cast_scan(scene, number - gap).scan, *scene.trajectory);
      r.rays = std::make_shared<RayImage>(other.first);
    }
  }
  // What is taken, where the front has this velocity.
  std::vector<std::uint32_t> take(SlidingSides& sides, double speed_mps, double std_mps = 0.1, int age = 1) {
    TrackedObject front;
    front.age = age;
    front.id = 7;
    front.number = 1;
    front.velocity_0 = {speed_mps, 0, 0};
    front.velocity_covariance_0 = std_mps * std_mps * Eigen::Matrix3d::Identity();
    TrackMotion motion;
    motion.moves = true;
    return sides.take(*scan_, proposed_, {front}, {motion}, object_);
  }
  [[nodiscard]] bool on_box(std::uint32_t i) const {
    const Vector3d p_0 = proposed_.points.origin_0 + proposed_.points.points[i].cast<double>();
    return std::abs(p_0.y() - kSide_m) < 0.15 && std::abs(p_0.z()) < 1.1;
  }
  [[nodiscard]] std::size_t side() const { return side_; }  // points behind the front
  [[nodiscard]] const std::vector<std::uint16_t>& object() const { return object_; }

 private:
  std::shared_ptr<const LidarScan> scan_;
  ObjectProposals proposed_;
  std::vector<std::uint16_t> object_;
  std::size_t side_ = 0;
};

// At 2 m/s its rear was 0.8 m farther back four scans before, where rays now pass.
TEST(SlidingSides, TheSideBelongsToTheFrontWhereTheRearMovedToo) {
  Scan scan(room_with_bus(2), kScan, 2);
  ASSERT_GT(scan.side(), 2000u);
  SlidingSides sides;
  const auto taken = scan.take(sides, 2);
  EXPECT_GT(taken.size(), 0.9 * static_cast<double>(scan.side()));
  for (const std::uint32_t i : taken) {
    EXPECT_TRUE(scan.on_box(i)) << i;
    EXPECT_EQ(scan.object()[i], 1);
  }
}

// What starts in front of a thing that stands in the same line does not take it along, nor does what passes
// it.
TEST(SlidingSides, TheRearOfWhatStandsNeverMoved) {
  Scan scan(room_with_bus(0), kScan, 0);
  for (const double claimed_mps : {1.0, 2.0, 8.0}) {
    SlidingSides sides;
    EXPECT_TRUE(scan.take(sides, claimed_mps).empty()) << claimed_mps;
  }
}

// Of two that stand behind one another, 0.4 m apart, the first has no rear that became free.
TEST(SlidingSides, ASideThatStandsBeforeAnotherDoesNotMove) {
  auto room = room_with_bus(0);
  room.world.push_back(
      test::toy_box({kFront_m - 3 * kHalfLength_m - 0.4, kSide_m + 1, 0}, {kHalfLength_m, 1, 1}));
  SlidingSides sides;
  EXPECT_TRUE(Scan(room, kScan, 0).take(sides, 2).empty());
}

// In one of five scans before something was where its rear would have been.
TEST(SlidingSides, OneScanAloneDoesNotShowThatTheRearMoved) {
  for (const auto& [farther_back, taken] :
       {std::pair{std::vector{4}, false}, {std::vector{3, 4, 6, 8, 12}, true}}) {
    Scan scan(room_with_bus(0), kScan, 0);
    auto longer = room_with_bus(0);
    longer.world.back() =
        test::toy_box({kFront_m - kHalfLength_m - 1, kSide_m + 1, 0}, {kHalfLength_m, 1, 1});
    for (const int gap : farther_back) scan.replace_reference(gap, longer, kScan);
    SlidingSides sides;
    EXPECT_EQ(!scan.take(sides, 2).empty(), taken) << farther_back.size();
  }
}

// What hangs over at the rear goes on ahead of an object that moves the other way.
TEST(SlidingSides, WhatGoesOnAheadOfTheObjectIsNotItsSide) {
  SlidingSides sides;
  EXPECT_TRUE(Scan(room_with_bus(2), kScan, 2).take(sides, -2).empty());
}

// The road behind a vehicle: the vehicle hid it before, from 0.8 s ago on. At 4 m/s the front has passed at
// least 1.6 m since then, 0.1 m more than it is long. A track of 8 scans was not there 8 scans ago.
TEST(SlidingSides, WhatTheFrontItselfHidIsNotItsSide) {
  auto hidden = room_with_bus(4);
  hidden.world.push_back(test::toy_box({0.9, kSide_m / 2, 0}, {0.6, 0.2, 1}));
  for (const auto& [age, taken] : {std::pair{8, true}, {9, false}}) {
    Scan scan(room_with_bus(4), kScan, 4);
    scan.replace_reference(8, hidden, kScan);
    SlidingSides sides;
    EXPECT_EQ(!scan.take(sides, 4, 0.1, age).empty(), taken) << age;
  }
}

// Its velocity differs from zero by 2 sigma: only a rear that was seen to move before, within a second,
// counts.
TEST(SlidingSides, ARearThatWasSeenToMoveMovesOn) {
  const auto room = room_with_bus(2);
  SlidingSides sides;
  Scan scan(room, kScan, 2);
  EXPECT_TRUE(scan.take(sides, 2, 1).empty());
  EXPECT_FALSE(scan.take(sides, 2).empty());
  Scan next(room, kScan + 3, 2);
  const auto taken = next.take(sides, 2, 1);
  EXPECT_GT(taken.size(), 0.9 * static_cast<double>(next.side()));
  for (const std::uint32_t i : taken) EXPECT_TRUE(next.on_box(i)) << i;
  EXPECT_TRUE(Scan(room, kScan + 14, 2).take(sides, 2, 1).empty());
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
