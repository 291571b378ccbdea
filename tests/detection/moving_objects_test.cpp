#include "detection/moving_objects.hpp"

#include <gtest/gtest.h>

#include "support/toy_scene.hpp"
#include <mapless/geometry/compensated_scan.hpp>

namespace mapless {
namespace {

constexpr double kAdvance_m = 1;  // far more than an object needs

test::ToyScene room_with_box(double speed_mps) {
  auto room = test::toy_room("OS1-64", test::drive(0, 0));
  room.world.push_back(test::toy_box({4, -1, 0}, {0.5, 0.5, 0.8}));
  room.world.back().velocity_0 = {0, speed_mps, 0};
  room.world.back().object = 1;
  return room;
}

// By its place: truth names only what moves.
bool is_of_box(const test::ToyScene& scene, const LidarScan& scan, const LidarReturn& r) {
  const test::ToyBody& box = scene.world.back();
  const Eigen::Vector3d centre = box.pose_at(scan.time_of(r)).translation();
  const Eigen::Vector3d off = r.position_v.cast<double>() - centre;
  return off.cwiseAbs().maxCoeff() < 0.9 && off.head<2>().cwiseAbs().maxCoeff() < 0.6;
}

/// The box, proposed with an advance, and its true points but for those beyond the first `most`.
ProposedObjects propose(const test::ToyScene& scene, int k, double advance_m, int most = 1 << 20) {
  const auto cast = test::cast_scan(scene, k);
  ProposedObjects proposed;
  Detection& detection = proposed.detection;
  detection.scan = cast.scan;
  detection.sequence_number = static_cast<std::size_t>(k);
  detection.trace.resize(detection.scan->returns.size());
  int count = 0;
  for (const LidarReturn& r : detection.scan->returns) {
    const bool of_box = is_of_box(scene, *cast.scan, r);
    detection.object.push_back(of_box && count < most ? 1 : 0);
    count += of_box ? 1 : 0;
  }
  detection.objects = 1;
  proposed.column_states = compensate(cast.scan, *scene.trajectory).column_states;
  proposed.advance_m = {static_cast<float>(advance_m)};
  return proposed;
}

TEST(MovingObjects, WhatGoesOnMovesAndWhatStandsHasNoNumber) {
  for (const double speed_mps : {0.0, 1.0}) {
    SCOPED_TRACE(speed_mps);
    const auto scene = room_with_box(speed_mps);
    MovingObjects moving{DetectorParameters{}};
    for (int k = 0; k < 6; ++k) {
      ProposedObjects proposed = propose(scene, k, k < 2 ? kAdvance_m : 0);
      const std::vector<std::uint16_t> box = proposed.detection.object;
      const Detection detection = moving.judge(std::move(proposed));
      if (k < 4) continue;
      const bool moves = speed_mps > 0;
      EXPECT_EQ(detection.objects, moves ? 1 : 0);
      EXPECT_EQ(detection.tracked.size(), moves ? 1u : 0u);
      for (std::size_t i = 0; i < box.size(); ++i) {
        EXPECT_EQ(detection.dynamic(i), moves && box[i] == 1);
        EXPECT_EQ(detection.trace[i].growth == GrowthVerdict::stopped, !moves && box[i] == 1);
      }
    }
  }
}

// An error of registration is no motion: without an advance nothing begins to move, whatever its speed.
TEST(MovingObjects, WithoutAdvanceNothingBeginsToMove) {
  const auto scene = room_with_box(1);
  MovingObjects moving{DetectorParameters{}};
  for (int k = 0; k < 5; ++k) EXPECT_EQ(moving.judge(propose(scene, k, 0.029)).objects, 0);
  EXPECT_EQ(moving.judge(propose(scene, 5, 0.031)).objects, 1);
}

TEST(MovingObjects, ANewObjectOfFewPointsHasToBeSeenAgain) {
  const auto scene = room_with_box(1);
  MovingObjects few{DetectorParameters{}};
  EXPECT_EQ(few.judge(propose(scene, 0, kAdvance_m, 14)).objects, 0);
  EXPECT_EQ(few.judge(propose(scene, 1, kAdvance_m, 14)).objects, 1);
  MovingObjects many{DetectorParameters{}};
  EXPECT_EQ(many.judge(propose(scene, 0, kAdvance_m, 15)).objects, 1);
}

// At 1 m/s it would have gone 1.1 m since its last advance, that of scan 1, by scan 12.
TEST(MovingObjects, WhatNeverAdvancesStandsWhateverItsSpeed) {
  const auto scene = room_with_box(1);
  MovingObjects moving{DetectorParameters{}};
  for (int k = 0; k < 14; ++k) {
    const int objects = moving.judge(propose(scene, k, k < 2 ? kAdvance_m : 0)).objects;
    if (k < 9) {
      EXPECT_EQ(objects, 1) << k;
    }
    if (k > 12) {
      EXPECT_EQ(objects, 0) << k;
    }
  }
}

// The method as published calls moving what its five steps do.
TEST(MovingObjects, AreAllThatThePublishedMethodProposes) {
  DetectorParameters parameters;
  parameters.method = DetectionMethod::published;
  MovingObjects moving{parameters};
  const auto scene = room_with_box(0);
  for (int k = 0; k < 3; ++k) {
    ProposedObjects proposed = propose(scene, k, 0);
    proposed.advance_m.clear();
    EXPECT_EQ(moving.judge(std::move(proposed)).tracked.size(), 1u);
  }
}

}  // namespace
}  // namespace mapless
