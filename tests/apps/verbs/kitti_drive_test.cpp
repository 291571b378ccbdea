#include <algorithm>
#include <array>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "support/paths.hpp"
#include <mapless/detection/detector.hpp>
#include <mapless/evaluation/evaluator.hpp>
#include <mapless/io/dataset.hpp>
#include <mapless/io/labels.hpp>
#include <mapless/io/trajectory_file.hpp>

// The real drive: a van and a cyclist move through the whole of it, in front of the camera; parked cars,
// ground and house fronts are static. Truth is by hand-drawn boxes and covers the camera's view only.
namespace mapless {
namespace MAPLESS_FILE {

constexpr std::size_t kScans = 24;

struct Mover {
  std::size_t points = 0;
  std::size_t found = 0;
};

// Left of the sensor's x axis drives the van, right of it the cyclist (until scan 30).
std::array<Mover, 2> van_and_cyclist(const Detection& detection, const std::vector<std::uint32_t>& truth) {
  std::array<Mover, 2> movers;
  for (std::size_t i = 0; i < detection.object.size(); ++i) {
    const LidarReturn& r = detection.scan->returns[i];
    if (motion_of_label(truth[r.input_index]) != MotionTruth::moving) continue;
    // A third mover leaves the camera's view, and with it the truth, in the first scans.
    if (r.position_v.y() < -4) continue;
    Mover& mover = movers[r.position_v.y() > 1.5F ? 0 : 1];
    ++mover.points;
    mover.found += detection.dynamic(i) ? 1 : 0;
  }
  return movers;
}

struct Outcome {
  std::size_t tp = 0, fp = 0, fn = 0;
  std::array<std::size_t, 2> found_in{};  // scans in which half of the mover's points are dynamic
  std::size_t scans = 0;
};

void count(const Dataset& drive, const Detection& detection, Outcome& outcome) {
  const auto truth = drive.read_labels(detection.sequence_number).value();
  for (std::size_t i = 0; i < detection.object.size(); ++i) {
    const MotionTruth motion = motion_of_label(truth[detection.scan->returns[i].input_index]);
    outcome.tp += detection.dynamic(i) && motion == MotionTruth::moving;
    outcome.fp += detection.dynamic(i) && motion == MotionTruth::still;
    outcome.fn += !detection.dynamic(i) && motion == MotionTruth::moving;
  }
  const auto movers = van_and_cyclist(detection, truth);
  for (std::size_t m = 0; m < movers.size(); ++m) {
    outcome.found_in[m] += 2 * movers[m].found >= movers[m].points;
  }
  ++outcome.scans;
}

TEST(KittiDrive, VanAndCyclistMoveAndTheRestStands) {
  const auto folder = test::shared_data("kitti_raw/2011_09_26/2011_09_26_drive_0005_sync");
  MAPLESS_SKIP_WITHOUT(folder);
  DatasetOptions options;
  options.labels = folder / "labels_derived";
  const auto drive = open_dataset(folder, options);
  TrajectoryRequest request;
  request.file = folder / "poses_icp.txt";
  const auto trajectory = open_trajectory(*drive, request).trajectory;

  Detector detector;
  Outcome outcome;
  for (std::size_t k = 0; k < kScans; ++k) {
    const auto scan = std::make_shared<const LidarScan>(drive->read(k));
    for (const auto& detection : detector.process(scan, *trajectory)) count(*drive, detection, outcome);
  }
  for (const auto& detection : detector.flush()) count(*drive, detection, outcome);

  EXPECT_EQ(outcome.scans, kScans);
  EXPECT_GE(outcome.found_in[0], kScans - 2) << "scans in which the van came out";
  EXPECT_GE(outcome.found_in[1], kScans - 2) << "scans in which the cyclist came out";
  const auto tp = static_cast<double>(outcome.tp);
  EXPECT_GE(tp / static_cast<double>(outcome.tp + outcome.fp), 0.98) << "precision";
  EXPECT_GE(tp / static_cast<double>(outcome.tp + outcome.fn), 0.80) << "recall";
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
