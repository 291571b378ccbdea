#include <iterator>
#include <thread>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include "support/detection/run_detector.hpp"
#include "support/toy_scene.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/geometry/compensated_scan.hpp>
#include <mapless/pipeline/online_detector.hpp>

namespace mapless {
namespace MAPLESS_FILE {

using Scans = std::vector<std::shared_ptr<const LidarScan>>;

constexpr int kScans = 16;  // odometry starts with the fifth to the tenth

const test::ToyScene& street() {
  static const test::ToyScene scene = with_columns(test::toy_street("VLP-16"), 400);
  return scene;
}

const Scans& scans() {
  static const Scans all = test::scans_of(test::cast_scans(street(), 0, kScans));
  return all;
}

void append(std::vector<LabelledScan>& all, std::vector<LabelledScan> more) {
  std::move(more.begin(), more.end(), std::back_inserter(all));
}

std::vector<LabelledScan> run(OnlineDetector& online, const Scans& pushed,
                              const std::shared_ptr<const Trajectory>& given = nullptr) {
  std::vector<LabelledScan> all;
  for (const auto& scan : pushed) append(all, online.push(scan, given));
  append(all, online.flush());
  return all;
}

std::vector<LabelledScan> run(const OnlineDetectorOptions& options, const Scans& pushed,
                              const std::shared_ptr<const Trajectory>& given = nullptr) {
  OnlineDetector online(options);
  return run(online, pushed, given);
}

OnlineDetectorOptions side_by_side() {
  OnlineDetectorOptions options;
  options.side_by_side = true;
  return options;
}

struct Expected {
  std::vector<Detection> detections;
  std::vector<SE3> T_v0;  // at the start of each scan, as known when it was labelled
};

// The three steps of the header, one after the other.
class PlainLoop {
 public:
  Expected run(const Scans& all) {
    Scans held_back;
    for (const auto& scan : all) {
      odometry_.process(scan);
      remove_dynamic_points();
      held_back.push_back(scan);
      if (!odometry_.started()) continue;
      for (const auto& known : held_back) keep(detector_.process(known, odometry_.trajectory()));
      if (held_back.size() > 1) remove_dynamic_points();
      held_back.clear();
    }
    keep(detector_.flush());
    return std::move(expected_);
  }

 private:
  void keep(const std::vector<Detection>& detections) {
    for (const Detection& detection : detections) {
      expected_.detections.push_back(detection);
      expected_.T_v0.push_back(odometry_.trajectory().at(detection.scan->start).T_v0);
    }
  }
  void remove_dynamic_points() {
    for (; removed_ < expected_.detections.size(); ++removed_) {
      const Detection& detection = expected_.detections[removed_];
      odometry_.remove_dynamic_points(*detection.scan, detection.object);
    }
  }

  LidarOdometry odometry_;
  Detector detector_;
  Expected expected_;
  std::size_t removed_ = 0;
};

const Expected& expected() {
  static const Expected all = PlainLoop().run(scans());
  return all;
}

void expect_same(const Detection& found, const Detection& wanted) {
  EXPECT_EQ(found.scan->start, wanted.scan->start);
  EXPECT_EQ(found.object, wanted.object);
  EXPECT_EQ(found.trace, wanted.trace);
  ASSERT_EQ(found.tracked.size(), wanted.tracked.size());
  for (std::size_t i = 0; i < found.tracked.size(); ++i) {
    EXPECT_EQ(found.tracked[i].id, wanted.tracked[i].id);
    EXPECT_EQ(found.tracked[i].velocity_0, wanted.tracked[i].velocity_0);
  }
}

void expect_plain_loop(const std::vector<LabelledScan>& found) {
  ASSERT_EQ(found.size(), expected().detections.size());
  for (std::size_t k = 0; k < found.size(); ++k) {
    SCOPED_TRACE(k);
    expect_same(found[k].detection, expected().detections[k]);
    EXPECT_EQ(found[k].detection.sequence_number, k);
    const SE3 T_v0 = found[k].trajectory->at(scans()[k]->start).T_v0;
    EXPECT_EQ(T_v0.matrix(), expected().T_v0[k].matrix());
    EXPECT_EQ(found[k].T_0v().matrix(), expected().T_v0[k].inverse().matrix());
    ASSERT_NE(found[k].odometry, nullptr);
    EXPECT_EQ(found[k].odometry->outcome, k == 0 ? ScanOutcome::first : ScanOutcome::registered);
  }
}

std::size_t dynamic_returns(const std::vector<LabelledScan>& found) {
  std::size_t count = 0;
  for (const LabelledScan& scan : found)
    for (std::size_t i = 0; i < scan.detection.object.size(); ++i) count += scan.detection.dynamic(i) ? 1 : 0;
  return count;
}

TEST(OnlineDetectorThreads, IsOdometryDetectionAndRemovalFromTheMapInTurn) {
  const auto found = run(OnlineDetectorOptions{}, scans());
  expect_plain_loop(found);
  EXPECT_GT(dynamic_returns(found), 100u) << "the street has moving cars: the removal must have mattered";
}

TEST(OnlineDetectorThreads, SideBySideGivesTheSame) { expect_plain_loop(run(side_by_side(), scans())); }

TEST(OnlineDetectorThreads, AnyNumberOfThreadsGivesTheSame) {
  for (const int threads : {1, 3}) {
    OnlineDetectorOptions options = side_by_side();
    options.detection_threads = threads;
    tbb::task_arena arena(threads);
    arena.execute([&] { expect_plain_loop(run(options, scans())); });
  }
}

// One after the other, the labels of a scan come with the push of the next; side by side, with the one after.
TEST(OnlineDetectorThreads, CatchingUpGivesTheLabelsBeforeTheNextPush) {
  OnlineDetector alone;
  OnlineDetector beside(side_by_side());
  std::vector<LabelledScan> all;
  for (const auto& scan : scans()) {
    const auto at_once = alone.push(scan);
    auto found = beside.push(scan);
    append(found, beside.catch_up());
    EXPECT_EQ(found.size(), at_once.size());
    EXPECT_TRUE(beside.catch_up().empty());
    append(all, std::move(found));
  }
  append(all, beside.flush());
  expect_plain_loop(all);
}

TEST(OnlineDetectorThreads, SideBySideTheLabelsComeOnePushLater) {
  OnlineDetector alone;
  OnlineDetector beside(side_by_side());
  std::size_t labelled = 0, labelled_beside = 0, before = 0;
  for (const auto& scan : scans()) {
    before = labelled;
    labelled += alone.push(scan).size();
    labelled_beside += beside.push(scan).size();
  }
  EXPECT_EQ(labelled, scans().size() - 1);  // latency() of the default parameters
  EXPECT_EQ(labelled_beside, before);
  EXPECT_EQ(alone.flush().size(), 1u);
  EXPECT_EQ(beside.flush().size(), 2u);
}

TEST(OnlineDetectorThreads, ResultsOutliveTheDetectorOnAnotherThread) {
  auto online = std::make_unique<OnlineDetector>(side_by_side());
  std::vector<LabelledScan> found;
  std::vector<std::thread> readers;
  std::vector<Eigen::Matrix4d> poses(scans().size());
  for (const auto& scan : scans()) {
    for (LabelledScan& labelled : online->push(scan)) {
      Eigen::Matrix4d& pose = poses[labelled.detection.sequence_number];
      readers.emplace_back([labelled = std::move(labelled), &pose] { pose = labelled.T_0v().matrix(); });
    }
  }
  found = online->flush();
  online.reset();
  for (std::thread& reader : readers) reader.join();
  for (const LabelledScan& labelled : found)
    poses[labelled.detection.sequence_number] = labelled.T_0v().matrix();
  for (std::size_t k = 0; k < poses.size(); ++k)
    EXPECT_EQ(poses[k], expected().T_v0[k].inverse().matrix()) << k;
}

TEST(OnlineDetector, GivenPosesAreUsedInPlaceOfOdometry) {
  OnlineDetector online;
  const auto found = run(online, scans(), street().trajectory);
  const auto wanted = test::detect_all(scans(), *street().trajectory, {});
  ASSERT_EQ(found.size(), wanted.size());
  for (std::size_t k = 0; k < found.size(); ++k) {
    expect_same(found[k].detection, wanted[k]);
    EXPECT_EQ(found[k].trajectory, street().trajectory);
    EXPECT_EQ(found[k].odometry, nullptr);
  }
  EXPECT_EQ(online.odometry_report().scans(), 0u);
}

// A live source has a new buffer of poses with every scan.
TEST(OnlineDetector, EachScanKeepsTheTrajectoryItWasGiven) {
  OnlineDetector online;
  std::vector<std::shared_ptr<const Trajectory>> given;
  std::vector<LabelledScan> found;
  for (const auto& scan : scans()) {
    given.push_back(std::make_shared<const test::MovedTrajectory>(street().trajectory, SE3(), Duration()));
    append(found, online.push(scan, given.back()));
  }
  append(found, online.flush());
  for (std::size_t k = 0; k < found.size(); ++k) EXPECT_EQ(found[k].trajectory, given[k]) << k;
}

TEST(OnlineDetector, CompensatedScansAreTakenBackToTheMeasuredRays) {
  Scans compensated, restored;
  for (int k = 0; k < 4; ++k) {
    LidarScan scan = *scans()[static_cast<std::size_t>(k)];
    const SE3 T_c0 = street().trajectory->at(scan.start).T_v0;
    for (LidarReturn& r : scan.returns) {
      const SE3 T_cv = T_c0 * street().trajectory->at(scan.time_of(r)).T_v0.inverse();
      r.position_v = (T_cv * r.position_v.cast<double>()).cast<float>();
    }
    scan.compensated_to = scan.start;
    restored.push_back(std::make_shared<const LidarScan>(restore_measured_rays(scan, *street().trajectory)));
    compensated.push_back(std::make_shared<const LidarScan>(std::move(scan)));
  }
  const auto found = run(OnlineDetectorOptions{}, compensated, street().trajectory);
  const auto wanted = run(OnlineDetectorOptions{}, restored, street().trajectory);
  ASSERT_EQ(found.size(), wanted.size());
  for (std::size_t k = 0; k < found.size(); ++k) expect_same(found[k].detection, wanted[k].detection);
  OnlineDetector online;
  EXPECT_THROW((void)online.push(compensated[0]), InputError) << "without poses it cannot be undone";
}

TEST(OnlineDetector, ObjectsComeInTheOrderOfTheInput) {
  const auto found = run(OnlineDetectorOptions{}, scans(), street().trajectory);
  for (const LabelledScan& labelled : found) {
    const auto by_input = labelled.object_by_input();
    ASSERT_EQ(by_input.size(), labelled.scan().input_size);
    std::vector<std::uint16_t> wanted(labelled.scan().input_size, 0);
    for (std::size_t i = 0; i < labelled.detection.object.size(); ++i)
      wanted[labelled.scan().returns[i].input_index] = labelled.detection.object[i];
    EXPECT_EQ(by_input, wanted);
  }
}

TEST(OnlineDetector, ARecordingThatEndsBeforeOdometryStartsIsLabelled) {
  const Scans few(scans().begin(), scans().begin() + 3);
  for (const bool beside : {false, true}) {
    OnlineDetectorOptions options;
    options.side_by_side = beside;
    OnlineDetector online(options);
    for (const auto& scan : few) EXPECT_TRUE(online.push(scan).empty());
    const auto found = online.flush();
    ASSERT_EQ(found.size(), few.size());
    for (std::size_t k = 0; k < few.size(); ++k) EXPECT_EQ(found[k].scan().start, few[k]->start);
    EXPECT_TRUE(online.flush().empty());
  }
  EXPECT_TRUE(OnlineDetector().flush().empty());
}

TEST(OnlineDetector, GoesOnAfterAFlush) {
  OnlineDetector online(side_by_side());
  const Scans first(scans().begin(), scans().begin() + 12);
  const Scans second(scans().begin() + 12, scans().end());
  EXPECT_EQ(run(online, first).size(), first.size());
  const auto found = run(online, second);
  ASSERT_EQ(found.size(), second.size());
  for (std::size_t k = 0; k < second.size(); ++k) {
    EXPECT_EQ(found[k].detection.sequence_number, first.size() + k);
    EXPECT_EQ(found[k].scan().start, second[k]->start);
  }
}

TEST(OnlineDetectorThreads, AScanThatIsRefusedChangesNothing) {
  for (const bool beside : {false, true}) {
    OnlineDetectorOptions options;
    options.side_by_side = beside;
    OnlineDetector online(options);
    std::vector<LabelledScan> found;
    for (const auto& scan : scans()) {
      append(found, online.push(scan));
      EXPECT_THROW((void)online.push(scan), InputError) << "the same scan again";
      EXPECT_THROW((void)online.push(scan, street().trajectory), InputError) << "poses, now";
    }
    append(found, online.flush());
    expect_plain_loop(found);
    EXPECT_EQ(online.odometry_report().scans(), scans().size());
  }
}

TEST(OnlineDetector, RefusesParametersOutOfBounds) {
  OnlineDetectorOptions options;
  options.detection_threads = -1;
  EXPECT_THROW(OnlineDetector{options}, ParameterError);
  options = {};
  options.odometry.gate_m = 0;
  EXPECT_THROW(OnlineDetector{options}, ParameterError);
  options = {};
  options.detection.voting.references = 0;
  EXPECT_THROW(OnlineDetector{options}, ParameterError);
}

TEST(OnlineDetector, AScanThatItsPosesDoNotCoverChangesNothing) {
  OnlineDetector online;
  const SampledTrajectory& early = [] {
    static const SampledTrajectory poses({{Time(), SE3()}, {Time::from_nanoseconds(1'000'000), SE3()}},
                                         Duration(), "poses");
    return poses;
  }();
  const std::shared_ptr<const Trajectory> short_one(std::shared_ptr<void>(), &early);
  EXPECT_THROW((void)online.push(scans()[0], short_one), TrajectoryDomainError);
  const auto found = run(online, scans(), street().trajectory);
  const auto wanted = test::detect_all(scans(), *street().trajectory, {});
  ASSERT_EQ(found.size(), wanted.size());
  for (std::size_t k = 0; k < found.size(); ++k) expect_same(found[k].detection, wanted[k]);
  EXPECT_THROW((void)online.push(scans()[0]), InputError) << "no poses, now";
}

// A drive without end: sixteen scans of a street with few points, again and again. The sensor jumps back with
// each round, and its odometry begins anew.
TEST(OnlineDetector, KeepsTheMotionOfTheLastScansOnly) {
  const Scans round = test::scans_of(test::cast_scans(with_columns(test::toy_street("VLP-16"), 90), 0, 16));
  const Duration period = round[1]->start - round[0]->start;
  OnlineDetector online;
  std::size_t labelled = 0;
  for (std::size_t k = 0; k < 700; ++k) {
    LidarScan scan = *round[k % round.size()];
    scan.start = round[0]->start + period * static_cast<double>(k);
    for (const LabelledScan& found : online.push(std::move(scan))) {
      ++labelled;
      ASSERT_LE(found.trajectory->begin(), found.scan().start);
      // 512 knots, a second, and a start-up.
      ASSERT_LT((found.scan().start - found.trajectory->begin()).seconds(), 56) << labelled;
    }
  }
  EXPECT_GT(labelled, 680u);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
