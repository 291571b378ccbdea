#include <algorithm>
#include <memory>

#include <gtest/gtest.h>

#include "support/paths.hpp"
#include <mapless/io/dataset.hpp>
#include <mapless/io/trajectory_file.hpp>
#include <mapless/odometry/lidar_odometry.hpp>

// The real drive: 3 to 7 m/s from the first scan on, a bend, traffic.
namespace mapless {
namespace MAPLESS_FILE {

Time middle_of(const Dataset& drive, std::size_t k) {
  return drive.scan_start(k) + (drive.scan_end(k) - drive.scan_start(k)) * 0.5;
}

SE3 step(const Trajectory& trajectory, Time from, Time to) {
  return trajectory.at(to).T_v0 * trajectory.at(from).T_v0.inverse();
}

TEST(KittiOdometry, EveryStepAgreesWithTheReferencePoses) {
  const auto folder = test::shared_data("kitti_raw/2011_09_26/2011_09_26_drive_0005_sync");
  MAPLESS_SKIP_WITHOUT(folder);
  const auto drive = open_dataset(folder, {});
  TrajectoryRequest request;
  request.file = folder / "poses_icp.txt";
  const auto reference = open_trajectory(*drive, request).trajectory;
  LidarOdometry odometry;
  for (std::size_t k = 0; k < drive->size(); ++k) {
    const auto update = odometry.process(std::make_shared<const LidarScan>(drive->read(k)));
    EXPECT_EQ(update.outcome, k == 0 ? ScanOutcome::first : ScanOutcome::registered) << "scan " << k;
    EXPECT_EQ(update.degeneracy.unconstrained, 0) << "scan " << k;
  }
  for (std::size_t k = 1; k < drive->size(); ++k) {
    const Time from = middle_of(*drive, k - 1), to = middle_of(*drive, k);
    const SE3 ours = step(odometry.trajectory(), from, to);
    const Vector6d difference = (ours * step(*reference, from, to).inverse()).log();
    EXPECT_LT(difference.head<3>().norm(), 0.1) << "scan " << k;
    EXPECT_LT(difference.tail<3>().norm(), 0.003) << "scan " << k;
  }
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
