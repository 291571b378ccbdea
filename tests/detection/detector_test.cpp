#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include <gtest/gtest.h>

#include "support/detection/run_detector.hpp"
#include "support/toy_scene.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/detection/detector.hpp>
#include <mapless/io/labels.hpp>

namespace mapless {
namespace MAPLESS_FILE {

using Eigen::Vector3d;

/// Half a metre long and 8 m/s fast, in a furnished room: from one scan to the next it leaves its own length
/// behind it, and every place it comes to was free.
test::ToyScene room_with_box(std::shared_ptr<const Trajectory> trajectory, double speed = 8) {
  test::ToyScene scene = test::toy_room("HDL-64E-S3", std::move(trajectory));
  test::ToyBody box = test::toy_box({-7, 4.5, -0.1}, {0.25, 0.25, 0.6});
  box.velocity_0 = {speed, 0, 0};
  box.object = 1;
  scene.world.push_back(box);
  return scene;
}

struct Found {
  int moving = 0;     // points of the box
  int of_moving = 0;  // found
  int of_still = 0;   // false ones
  [[nodiscard]] double recall() const { return moving == 0 ? 0 : static_cast<double>(of_moving) / moving; }
};

Found found(const Detection& detection, const test::ToyScan& scan) {
  Found f;
  for (std::size_t i = 0; i < detection.trace.size(); ++i) {
    const std::uint32_t label = scan.labels[detection.scan->returns[i].input_index];
    const bool moves = motion_of_label(label) == MotionTruth::moving;
    f.moving += moves ? 1 : 0;
    f.of_moving += moves && detection.dynamic(i) ? 1 : 0;
    f.of_still += !moves && detection.dynamic(i) ? 1 : 0;
  }
  return f;
}

DetectorParameters with_forward_gap(int gap) {
  DetectorParameters parameters;
  parameters.forward_gap = gap;
  return parameters;
}

TEST(Detector, FindsABoxThatMovesInEveryScanAndNoFurniture) {
  for (const auto& trajectory : {test::drive(0, 0), test::drive(0.5, 0.3)}) {
    const auto scene = room_with_box(trajectory);
    const auto scans = test::cast_scans(scene, 0, 16);
    const auto detections = test::detect_all(test::scans_of(scans), *trajectory, {});
    ASSERT_EQ(detections.size(), scans.size());
    for (std::size_t k = 0; k < scans.size(); ++k) {
      SCOPED_TRACE(testing::Message() << "scan " << k);
      const Found f = found(detections[k], scans[k]);
      ASSERT_GT(f.moving, 100);
      EXPECT_GE(f.recall(), 0.9);
      EXPECT_LE(f.of_still, f.moving / 50);
      EXPECT_EQ(detections[k].objects, 1);
    }
  }
}

TEST(Detector, AStandingBoxNeverMoves) {
  for (const auto& trajectory : {test::drive(0, 0), test::drive(1, -0.5)}) {
    const auto scans = test::cast_scans(room_with_box(trajectory, 0), 0, 12);
    for (const Detection& d : test::detect_all(test::scans_of(scans), *trajectory, {}))
      EXPECT_EQ(d.objects, 0) << "scan " << d.sequence_number;
  }
}

// The box stops as scan kStop starts: 8 m/s one scan, 0 the next. It moves until it has been slow in two
// scans, of which kStop - 1 is none, and its velocity is that of the last few. From scan kStop + 6 on neither
// the registration nor the scans of a moment ago, which are the nearest four, know of any motion.
TEST(Detector, WhatStopsIsSoonStatic) {
  constexpr int kStop = 12;
  const auto trajectory = test::drive(0, 0);
  auto scene = room_with_box(trajectory);
  auto scans = test::cast_scans(scene, 0, kStop);
  test::ToyBody& box = scene.world.back();
  box.T_0b = box.pose_at(scans.back().scan->end());
  box.velocity_0.setZero();
  for (const auto& scan : test::cast_scans(scene, kStop, 11)) scans.push_back(scan);
  const auto detections = test::detect_all(test::scans_of(scans), *trajectory, {});
  for (std::size_t k = 8; k + 1 < detections.size(); ++k) {
    SCOPED_TRACE(testing::Message() << "scan " << k);
    const auto stopped =
        std::count_if(detections[k].trace.begin(), detections[k].trace.end(),
                      [](const StageTrace& t) { return t.growth == GrowthVerdict::static_track; });
    if (k <= kStop) {
      EXPECT_EQ(detections[k].objects, 1);
      EXPECT_EQ(stopped, 0);
    } else {  // it does not begin again
      EXPECT_LE(detections[k].objects, detections[k - 1].objects);
    }
    if (k >= kStop + 6) {
      EXPECT_EQ(detections[k].objects, 0);
    }
    if (k == kStop + 6) {  // it is proposed still
      EXPECT_GT(stopped, 100);
    }
  }
}

TEST(Detector, AnswersWhileARecordingIsYoung) {
  const auto scene = room_with_box(test::drive(0, 0));
  const auto scans = test::cast_scans(scene, 0, 4);
  const auto all = test::scans_of(scans);
  for (std::size_t size = 1; size <= all.size(); ++size) {
    for (const int gap : {0, 1, 2, 5}) {
      SCOPED_TRACE(testing::Message() << size << " scans, forward gap " << gap);
      const auto detections = test::detect_all({all.begin(), all.begin() + static_cast<std::ptrdiff_t>(size)},
                                               *scene.trajectory, with_forward_gap(gap));
      ASSERT_EQ(detections.size(), size);
      for (std::size_t k = 0; k < size; ++k) {
        EXPECT_EQ(detections[k].sequence_number, k);
        const bool alone = k == 0 && (size == 1 || gap == 0);
        const Found f = found(detections[k], scans[k]);
        EXPECT_EQ(f.of_still, 0) << "scan " << k;
        if (alone) {
          EXPECT_EQ(detections[k].objects, 0);
        } else {
          EXPECT_GE(f.recall(), 0.9) << "scan " << k;
        }
      }
    }
  }
}

// However far back the only reference scan lies.
TEST(Detector, FindsABoxByOneEarlierScanOnly) {
  const auto scene = room_with_box(test::drive(0, 0));
  const auto scans = test::cast_scans(scene, 0, 12);
  DetectorParameters parameters = with_forward_gap(0);
  parameters.voting.references = 1;
  for (const int gap : {1, 4, 8}) {
    parameters.voting.first_gap = gap;
    const auto detections = test::detect_all(test::scans_of(scans), *scene.trajectory, parameters);
    for (std::size_t k = 2; k < scans.size(); ++k) {
      SCOPED_TRACE(testing::Message() << "scan " << k << ", " << gap << " back");
      EXPECT_GE(found(detections[k], scans[k]).recall(), 0.9);
    }
  }
}

TEST(Detector, AScanAloneIsStaticAndNobodySaysOtherwise) {
  const auto scene = room_with_box(test::drive(0, 0));
  const auto scans = test::scans_of(test::cast_scans(scene, 0, 1));
  const auto detections = test::detect_all(scans, *scene.trajectory, {});
  ASSERT_EQ(detections.size(), 1u);
  for (const StageTrace& t : detections[0].trace) {
    EXPECT_EQ(t.candidate, CandidateVerdict::not_compared);
    EXPECT_EQ(t.past, FreespaceVerdict::unobserved);
    EXPECT_EQ(t.filtered, FilterVerdict::not_evaluated);
  }
}

TEST(Detector, DetectionsComeOutLatencyScansLater) {
  const auto scene = room_with_box(test::drive(0, 0));
  const auto scans = test::scans_of(test::cast_scans(scene, 0, 4));
  EXPECT_EQ(Detector().latency(), 1);
  for (const auto method : {DetectionMethod::voting, DetectionMethod::published}) {
    for (const int gap : {0, 1, 3}) {
      DetectorParameters parameters = with_forward_gap(gap);
      parameters.method = method;
      parameters.voting.start_scans = 1;
      Detector detector(parameters);
      EXPECT_EQ(detector.latency(), gap);
      for (std::size_t k = 0; k < scans.size(); ++k) {
        const auto ready = detector.process(scans[k], *scene.trajectory);
        ASSERT_EQ(ready.size(), k >= static_cast<std::size_t>(gap) ? 1u : 0u);
        for (const Detection& d : ready) EXPECT_EQ(d.sequence_number, k - static_cast<std::size_t>(gap));
      }
      EXPECT_EQ(detector.flush().size(), static_cast<std::size_t>(gap));
      EXPECT_TRUE(detector.flush().empty());
    }
  }
}

TEST(Detector, TheFirstDetectionsComeTogether) {
  const auto scene = room_with_box(test::drive(0, 0));
  const auto scans = test::scans_of(test::cast_scans(scene, 0, 5));
  for (const auto& [gap, expected] :
       {std::pair{1, std::array{0u, 0u, 2u, 1u, 1u}}, std::pair{2, std::array{0u, 0u, 1u, 1u, 1u}},
        std::pair{0, std::array{1u, 1u, 1u, 1u, 1u}}}) {
    DetectorParameters parameters = with_forward_gap(gap);
    parameters.voting.start_scans = 3;
    Detector detector(parameters);
    std::size_t next = 0;
    for (std::size_t k = 0; k < scans.size(); ++k) {
      const auto ready = detector.process(scans[k], *scene.trajectory);
      ASSERT_EQ(ready.size(), expected.at(k)) << "scan " << k << ", gap " << gap;
      for (const Detection& d : ready) EXPECT_EQ(d.sequence_number, next++);
    }
    EXPECT_EQ(detector.flush().size(), scans.size() - next);
  }
}

// What a scan that is refused leaves behind: nothing.
TEST(Detector, GoesOnAfterAScanItRefused) {
  const auto scene = room_with_box(test::drive(0, 0));
  const auto scans = test::scans_of(test::cast_scans(scene, 0, 5));
  const auto expected = test::detect_all(scans, *scene.trajectory, {});
  const SampledTrajectory short_one({{Time::from_seconds(-1), SE3()}, {Time::from_seconds(0.21), SE3()}},
                                    Duration(), "short");
  Detector detector;
  std::vector<Detection> detections;
  for (const auto& scan : scans) {
    if (scan->start > Time::from_seconds(0.15)) {
      EXPECT_THROW(static_cast<void>(detector.process(scan, short_one)), TrajectoryDomainError);
      EXPECT_THROW(static_cast<void>(detector.process(scans[0], *scene.trajectory)), InputError);
    }
    std::ranges::move(detector.process(scan, *scene.trajectory), std::back_inserter(detections));
  }
  std::ranges::move(detector.flush(), std::back_inserter(detections));
  ASSERT_EQ(detections.size(), expected.size());
  for (std::size_t k = 0; k < detections.size(); ++k) EXPECT_EQ(detections[k].object, expected[k].object);
}

// A recording longer than the farthest reference scan: a scan that is forgotten is not queried again.
TEST(Detector, ForgetsScansNobodyWillAsk) {
  const auto scene = room_with_box(test::drive(0, 0), 0.4);
  const auto scans = test::cast_scans(scene, 0, 12);
  for (const auto& [references, first_gap] : {std::pair{1, 1}, std::pair{2, 1}, std::pair{1, 4}}) {
    DetectorParameters parameters;
    parameters.voting.references = references;
    parameters.voting.first_gap = first_gap;
    EXPECT_EQ(test::detect_all(test::scans_of(scans), *scene.trajectory, parameters).size(), scans.size());
  }
}

// An object slides within itself for the scans of a moment ago, not for those of seconds ago. The wall it
// uncovers is more than max_occluder_distance_m behind its face.
TEST(Detector, FindsAWallThatSlidesOnceItHasLeftItsOwnLength) {
  test::ToyScene scene = test::toy_room("HDL-64E-S3", test::drive(0, 0));
  test::ToyBody lorry = test::toy_box({-5, 3.6, 0.1}, {1.5, 0.3, 0.6});
  lorry.velocity_0 = {2.5, 0, 0};
  lorry.object = 1;
  scene.world.push_back(lorry);
  const auto scans = test::cast_scans(scene, 0, 36);
  const auto detections = test::detect_all(test::scans_of(scans), *scene.trajectory, {});
  // 3 m at 2.5 m/s: 1.2 s. Of scans 16 and more back it has left its place, of those 8 and less back only in
  // part; its front, which all say is new, makes seeds, and growth goes over what any scan saw through.
  for (std::size_t k = 17; k + 1 < scans.size(); ++k) {
    const Found f = found(detections[k], scans[k]);
    EXPECT_GE(f.recall(), 0.9) << "scan " << k;
    EXPECT_LE(f.of_still, f.moving / 50) << "scan " << k;
  }
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
