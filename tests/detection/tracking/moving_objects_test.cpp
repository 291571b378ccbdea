#include "detection/tracking/moving_objects.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <gtest/gtest.h>

#include "support/toy_scene.hpp"
#include <mapless/geometry/compensated_scan.hpp>

namespace mapless {
namespace MAPLESS_FILE {

constexpr double kDisplacement_m = 1;  // far more than min_displacement_m
constexpr int kVotes = 1000;           // far more than min_evidence

test::ToyScene room_with_box(double speed_mps) {
  auto room = test::toy_room("OS1-64", test::drive(0, 0));
  room.world.push_back(test::toy_box({4, -1, 0}, {0.5, 0.5, 0.8}));
  room.world.back().velocity_0 = {0, speed_mps, 0};
  room.world.back().object = 1;
  return room;
}

// By its place: ground truth names moving bodies only.
bool is_of_box(const test::ToyScene& scene, const LidarScan& scan, const LidarReturn& r) {
  const test::ToyBody& box = scene.world.back();
  const Eigen::Vector3d centre = box.pose_at(scan.time_of(r)).translation();
  const Eigen::Vector3d off = r.position_v.cast<double>() - centre;
  return off.cwiseAbs().maxCoeff() < 0.9 && off.head<2>().cwiseAbs().maxCoeff() < 0.6;
}

/// The box as a proposed object, with displacement and votes.
ObjectProposals propose(const test::ToyScene& scene, int k, double displacement_m, int votes = kVotes) {
  const auto cast = test::cast_scan(scene, k);
  ObjectProposals proposed;
  proposed.scan = cast.scan;
  proposed.points.origin_0.setZero();
  proposed.trace.resize(proposed.scan->returns.size());
  proposed.votes.resize(proposed.scan->returns.size());
  for (const LidarReturn& r : proposed.scan->returns) proposed.points.points.push_back(r.position_v);
  for (const LidarReturn& r : proposed.scan->returns)
    proposed.object.push_back(is_of_box(scene, *cast.scan, r) ? 1 : 0);
  proposed.objects = 1;
  proposed.column_states = compensate(cast.scan, *scene.trajectory).column_states;
  proposed.evidence = {{static_cast<float>(displacement_m), votes}};
  return proposed;
}

TEST(MovingObjects, NumbersMovingObjectsOnly) {
  for (const double speed_mps : {0.0, 1.0}) {
    SCOPED_TRACE(speed_mps);
    const auto scene = room_with_box(speed_mps);
    MovingObjects moving{DetectorParameters{}};
    for (int k = 0; k < 6; ++k) {
      ObjectProposals proposed = propose(scene, k, k < 2 ? kDisplacement_m : 0);
      const std::vector<std::uint16_t> box = proposed.object;
      const Detection detection = moving.classify(std::move(proposed));
      if (k < 4) continue;
      const bool moves = speed_mps > 0;
      EXPECT_EQ(detection.objects, moves ? 1 : 0);
      EXPECT_EQ(detection.tracked.size(), moves ? 1u : 0u);
      for (std::size_t i = 0; i < box.size(); ++i) {
        EXPECT_EQ(detection.dynamic(i), moves && box[i] == 1);
        EXPECT_EQ(detection.trace[i].growth == GrowthVerdict::static_track, !moves && box[i] == 1);
      }
    }
  }
}

// The rims of an object that moves are static, and not counted with it.
TEST(MovingObjects, RimsAreNoPartOfLabels) {
  const auto scene = room_with_box(1);
  MovingObjects moving{DetectorParameters{}};
  for (int k = 0; k < 4; ++k) {
    ObjectProposals proposed = propose(scene, k, kDisplacement_m);
    const std::vector<std::uint16_t> box = proposed.object;
    const auto points = static_cast<int>(std::count(box.begin(), box.end(), 1));
    const auto first = std::find(box.begin(), box.end(), 1) - box.begin();
    proposed.rims = {static_cast<std::int32_t>(first)};
    const Detection detection = moving.classify(std::move(proposed));
    ASSERT_EQ(detection.objects, 1);
    EXPECT_EQ(detection.tracked.front().points, points - 1);
    for (std::size_t i = 0; i < box.size(); ++i)
      EXPECT_EQ(detection.dynamic(i), box[i] == 1 && i != static_cast<std::size_t>(first));
  }
}

// An error of the registration is no motion: without displacement no object begins to move, whatever its
// speed.
TEST(MovingObjects, NothingBeginsToMoveWithoutDisplacement) {
  const auto scene = room_with_box(1);
  MovingObjects moving{DetectorParameters{}};
  for (int k = 0; k < 5; ++k) EXPECT_EQ(moving.classify(propose(scene, k, 0.029)).objects, 0);
  EXPECT_EQ(moving.classify(propose(scene, 5, 0.031)).objects, 1);
}

// After more than a second an object is a new track without past evidence (which after ten scans is 1 /
// 1024).
TEST(MovingObjects, AnObjectUnseenForMoreThanASecondIsNew) {
  const auto scene = room_with_box(1);
  for (const int again : {11, 13}) {
    SCOPED_TRACE(again);
    MovingObjects moving{DetectorParameters{}};
    const auto objects = [&](int k) {
      return moving.classify(propose(scene, k, kDisplacement_m, 45)).objects;
    };
    EXPECT_EQ(objects(0), 0);  // 45 votes of 60
    EXPECT_EQ(objects(1), 1);  // 67
    EXPECT_EQ(objects(again), again == 11 ? 1 : 0);
    EXPECT_EQ(objects(again + 1), 1);
  }
}

// The box moves in scans 0 to 2 at 1 m/s and stands afterwards, until it moves again. Of a rest of 4.5 s it
// keeps its id, of one of 5.4 s it does not.
TEST(MovingObjects, AnIdIsForgottenAfterALongRest) {
  auto scene = room_with_box(1);
  scene.world.back().T_0b = test::toy_box({4, -3, 0}, {0.5, 0.5, 0.8}).T_0b;
  auto standing = scene;
  standing.world.back() = test::toy_box({4, -2.8, 0}, {0.5, 0.5, 0.8});
  for (const int rest : {45, 54}) {
    SCOPED_TRACE(rest);
    MovingObjects moving{DetectorParameters{}};
    const auto id = [&](const test::ToyScene& now, int k, double displacement_m) {
      const auto tracked = moving.classify(propose(now, k, displacement_m)).tracked;
      return tracked.empty() ? 0 : tracked.front().id;
    };
    for (const int k : {0, 1, 2}) EXPECT_EQ(id(scene, k, kDisplacement_m), 1u);
    int last = 2;  // in which it moves
    while (last < 9 && id(standing, last + 1, 0) == 1) ++last;
    ASSERT_LT(last, 9);
    for (int n = 9; n < rest - 3; n += 8) EXPECT_EQ(id(standing, last + n, 0), 0u);
    auto again = scene;
    const int first = last + rest - 3;
    again.world.back().T_0b = test::toy_box({4, -2.8 - 0.1 * first, 0}, {0.5, 0.5, 0.8}).T_0b;
    for (const int k : {first, first + 1, first + 2}) id(again, k, kDisplacement_m);
    EXPECT_EQ(id(again, last + rest, kDisplacement_m), rest == 45 ? 1u : 2u);
  }
}

// The second half of the box is an object of its own: the one with a displacement moves, and has number 1.
TEST(MovingObjects, EveryObjectHasItsOwnDisplacement) {
  const auto scene = room_with_box(0);
  for (const bool second : {false, true}) {
    SCOPED_TRACE(second);
    ObjectProposals proposed = propose(scene, 0, kDisplacement_m);
    std::vector<std::uint16_t>& object = proposed.object;
    std::size_t count = 0;
    for (std::uint16_t& number : object) {
      if (number != 0 && ++count > 50) number = 2;
    }
    ASSERT_GT(count, 100u);
    proposed.objects = 2;
    proposed.evidence = {{second ? 0 : 1.F, kVotes}, {second ? 1.F : 0, kVotes}};
    const std::vector<std::uint16_t> before = object;
    const Detection detection = MovingObjects{DetectorParameters{}}.classify(std::move(proposed));
    for (std::size_t i = 0; i < before.size(); ++i)
      EXPECT_EQ(detection.object[i], before[i] == (second ? 2 : 1) ? 1 : 0);
    ASSERT_EQ(detection.tracked.size(), 1u);
    EXPECT_EQ(detection.tracked.front().id, 1u);  // whatever static tracks there are
  }
}

constexpr double kPace_mps = 2;

// A bar that keeps pace with a sensor: what a sensor sees of a rail does so, too.
class Bar : public testing::Test {
 protected:
  Bar() {
    scene_.world.push_back(test::toy_box({0, 2, 0.05}, {1, 0.02, 0.03}));
    scene_.world.back().velocity_0 = {kPace_mps, 0, 0};
    scene_.world.back().object = 1;
  }

  // It as a proposed object of scan k, whose points are said to lie on a line or not, beside a sensor that is
  // said to have a velocity.
  [[nodiscard]] ObjectProposals propose(int k, bool on_line, double sensor_mps) const {
    ObjectProposals proposed;
    auto [compensated, points] = compensate_locally(test::cast_scan(scene_, k).scan, *scene_.trajectory);
    proposed.scan = compensated.scan;
    proposed.sensor_velocity_0 = {sensor_mps, 0, 0};
    for (const Eigen::Vector3f& p : points.points) {
      const bool of_bar = std::abs(p.x()) < 1.5F && std::abs(p.y() - 2) < 0.1F && std::abs(p.z()) < 0.2F;
      proposed.object.push_back(of_bar ? 1 : 0);
    }
    proposed.trace.resize(points.points.size());
    proposed.votes.resize(points.points.size());
    proposed.points = std::move(points);
    proposed.objects = 1;
    proposed.evidence.emplace_back();
    proposed.evidence.back().displacement_m = 1;
    proposed.evidence.back().votes = 1000;
    if (on_line) proposed.evidence.back().line_0 = {1, 0, 0};
    proposed.column_states = std::move(compensated.column_states);
    return proposed;
  }

  test::ToyScene scene_ = test::toy_room("OS1-64", test::drive(kPace_mps, 0));
};

// Evidence and displacement are ample in all three cases.
TEST_F(Bar, IsStaticWhereItsPointsLieOnALineAndTheSensorHasItsVelocity) {
  for (const auto& [on_line, sensor_mps] : {std::pair{true, kPace_mps}, {false, kPace_mps}, {true, 0.0}}) {
    SCOPED_TRACE(testing::Message() << on_line << " " << sensor_mps);
    MovingObjects moving{DetectorParameters{}};
    for (int k = 0; k < 5; ++k) {
      const Detection detection = moving.classify(propose(k, on_line, sensor_mps));
      if (k < 3) continue;
      const bool rail = on_line && sensor_mps > 0;
      ASSERT_EQ(detection.objects, rail ? 0 : 1);
      if (rail) continue;
      EXPECT_NEAR(detection.tracked.front().velocity_0.x(), kPace_mps, 0.9);
    }
  }
}

/// Objects 1 to 3 with two points each, between static points.
Detection three_objects() {
  Detection detection;
  detection.object = {0, 1, 2, 3, 0, 3, 2, 1};
  detection.trace.resize(detection.object.size());
  for (StageTrace& trace : detection.trace) trace.growth = GrowthVerdict::grown;
  detection.objects = 3;
  for (std::uint16_t number = 1; number <= 3; ++number) {
    detection.tracked.emplace_back().number = number;
    detection.tracked.back().id = 10U + number;
  }
  return detection;
}

TEST(KeepMoving, RenumbersMovingObjectsAndMarksTheOthersStatic) {
  Detection detection = three_objects();
  keep_moving({true, false, true}, detection);
  EXPECT_EQ(detection.object, (std::vector<std::uint16_t>{0, 1, 0, 2, 0, 2, 0, 1}));
  EXPECT_EQ(detection.objects, 2);
  ASSERT_EQ(detection.tracked.size(), 2u);
  for (const std::size_t k : {0, 1}) {
    EXPECT_EQ(detection.tracked[k].number, k + 1);
    EXPECT_EQ(detection.tracked[k].id, k == 0 ? 11u : 13u);
  }
  for (std::size_t i = 0; i < detection.trace.size(); ++i) {
    EXPECT_EQ(detection.trace[i].growth,
              i == 2 || i == 6 ? GrowthVerdict::static_track : GrowthVerdict::grown)
        << i;
  }
}

TEST(KeepMoving, LeavesNoObjectIfNoneMoves) {
  Detection detection = three_objects();
  keep_moving({false, false, false}, detection);
  EXPECT_EQ(detection.object, std::vector<std::uint16_t>(8, 0));
  EXPECT_EQ(detection.objects, 0);
  EXPECT_TRUE(detection.tracked.empty());
}

// Objects that share the last number, 65535, are one to the tracker.
TEST(KeepMoving, ObjectsThatShareTheLastNumberMoveTogether) {
  Detection detection = three_objects();
  detection.object = {65535, 1, 65535, 65535, 0, 0, 0, 0};
  detection.objects = 65537;
  detection.tracked.pop_back();
  detection.tracked[1].number = 65535;
  Detection all = detection, last = detection;
  keep_moving({true, true}, all);
  EXPECT_EQ(all.object, (std::vector<std::uint16_t>{2, 1, 2, 2, 0, 0, 0, 0}));
  EXPECT_EQ(all.objects, 2);
  keep_moving({false, true}, last);
  EXPECT_EQ(last.object, (std::vector<std::uint16_t>{1, 0, 1, 1, 0, 0, 0, 0}));
  EXPECT_EQ(last.objects, 1);
}

TEST(KeepMoving, KeepsAllNumbers) {
  Detection detection;
  detection.objects = 65535;
  for (int number = 1; number <= 65535; ++number) {
    detection.object.push_back(static_cast<std::uint16_t>(number));
    detection.tracked.emplace_back().number = static_cast<std::uint16_t>(number);
  }
  detection.trace.resize(detection.object.size());
  const std::vector<std::uint16_t> before = detection.object;
  keep_moving(std::vector<bool>(65535, true), detection);
  EXPECT_EQ(detection.object, before);
  EXPECT_EQ(detection.objects, 65535);
}

// The method as published labels all proposed objects as dynamic.
TEST(MovingObjects, AreAllProposedObjectsOfThePublishedMethod) {
  DetectorParameters parameters;
  parameters.method = DetectionMethod::published;
  MovingObjects moving{parameters};
  const auto scene = room_with_box(0);
  for (int k = 0; k < 3; ++k) {
    ObjectProposals proposed = propose(scene, k, 0);
    proposed.evidence.clear();
    EXPECT_EQ(moving.classify(std::move(proposed)).tracked.size(), 1u);
  }
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
