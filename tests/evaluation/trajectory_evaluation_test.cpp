#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "support/memory_dataset.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/evaluation/trajectory_evaluation.hpp>

namespace mapless {
namespace MAPLESS_FILE {

using test::MemoryDataset;
using test::regular_starts;

constexpr int kScans = 20;
constexpr std::size_t kColumns = 10;

/// Straight on along x, a row every `step_s` from `first_s` to `last_s`.
std::vector<TimedPose> drive(double speed, double first_s, double last_s, double step_s) {
  std::vector<TimedPose> rows;
  for (int i = 0; first_s + i * step_s < last_s + 1e-9; ++i) {
    const double t = first_s + i * step_s;
    rows.push_back({Time::from_seconds(t), SE3(Eigen::Matrix3d::Identity(), {-speed * t, 0, 0})});
  }
  return rows;
}

SampledTrajectory trajectory(std::vector<TimedPose> rows) { return {std::move(rows), Duration(), "test"}; }

class TrajectoryEvaluation : public testing::Test {
 protected:
  MemoryDataset dataset{regular_starts(kScans), kColumns};
  SampledTrajectory truth = trajectory(drive(10, 0, 2, 0.01));
};

TEST_F(TrajectoryEvaluation, ComparesAtTheFirstRowOfEachScan) {
  for (const auto& [offset, step] : {std::pair{0.0, 0.1}, {0.0, 0.02}, {0.05, 0.1}}) {
    SCOPED_TRACE(testing::Message() << offset << " " << step);
    const auto pairs = pair_poses(dataset, truth, trajectory(drive(10, offset, 1.96, step)));
    ASSERT_EQ(pairs.size(), kScans);
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      EXPECT_EQ(pairs[k].scan, k);
      EXPECT_NEAR(pairs[k].time.seconds(), 0.1 * static_cast<double>(k) + offset, 1e-6);
      EXPECT_NEAR(pairs[k].T_0v_true.translation().x(), 10 * pairs[k].time.seconds(), 1e-6);
    }
  }
}

TEST_F(TrajectoryEvaluation, APoseAtTheEndOfAScanBelongsToTheNext) {
  auto rows = drive(10, 0.1, 2, 0.1);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    rows[i].time = rows[i].time + Duration::from_nanoseconds(i % 2 == 0 ? -1000 : 1000);
  }
  const auto pairs = pair_poses(dataset, truth, trajectory(rows));
  ASSERT_EQ(pairs.size(), 19u);
  for (std::size_t i = 0; i < pairs.size(); ++i) EXPECT_EQ(pairs[i].scan, i + 1);
}

TEST_F(TrajectoryEvaluation, ASpeedErrorOfOnePercentGivesTheseErrors) {
  const TrajectoryReport r = evaluate_trajectory(dataset, truth, trajectory(drive(10.1, 0, 2, 0.01)));
  EXPECT_EQ(r.rows, 201u);
  EXPECT_EQ(r.poses, 20u);
  EXPECT_NEAR(r.path_length_m, 19, 1e-6);
  EXPECT_NEAR(r.velocity->linear_m_per_s.rmse, 0.1, 1e-6);
  EXPECT_NEAR(r.velocity->angular_deg_per_s.max, 0, 1e-6);
  EXPECT_NEAR(r.relative_per_scan->translation_m.rmse, 0.01, 1e-6);
  EXPECT_EQ(r.relative_per_scan_settled->translation_m.count, 9u) << "scan 10 to 11 ... 18 to 19";
  // One of 17 returns counts; the scans have 10.
  EXPECT_EQ(r.displacement->scans, 16u);
  EXPECT_EQ(r.displacement->distance_m.count, 16u);
  EXPECT_EQ(r.displacement_settled->scans, 6u) << "scans 14 to 19";
}

TEST_F(TrajectoryEvaluation, LeavesOutScansTheEstimateDoesNotCover) {
  // Scans 4 to 7 have no pose of their own and lie in a gap: they, and those 4 after them, do not count. So
  // does the last scan, whose end is not covered.
  auto rows = drive(10.1, 0, 1.9, 0.1);
  rows.erase(rows.begin() + 4, rows.begin() + 8);
  const TrajectoryReport r = evaluate_trajectory(dataset, truth, trajectory(rows));
  EXPECT_EQ(r.poses, 16u);
  EXPECT_EQ(r.relative_per_scan->translation_m.count, 14u);
  EXPECT_NEAR(r.relative_per_scan->translation_m.max, 0.01, 1e-6);
  EXPECT_EQ(r.velocity->linear_m_per_s.count, 14u);
  // Scan 3 ends in the gap. Those left: 0 1 2, 8 to 18; with one 4 before: 12 to 18.
  EXPECT_EQ(r.displacement->scans, 7u);
}

TEST_F(TrajectoryEvaluation, RefusesATrajectoryAtOtherTimes) {
  auto rows = drive(10, 0, 2, 0.1);
  for (TimedPose& row : rows) row.time = row.time + Duration::from_seconds(50);
  EXPECT_THROW((void)evaluate_trajectory(dataset, truth, trajectory(rows)), InputError);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
