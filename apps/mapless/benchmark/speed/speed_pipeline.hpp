#pragma once

#include <memory>
#include <optional>
#include <vector>

#include <tbb/task_arena.h>

#include "run/busy_time.hpp"
#include "run/side_thread.hpp"
#include <mapless/detection/detector.hpp>
#include <mapless/odometry/lidar_odometry.hpp>

namespace mapless::app {

/// From scans to labels: odometry, detection along its trajectory, and what moves taken out of its map.
/// Either one after the other, or odometry of a scan beside the detection of the one before, on a thread of
/// its own.
class SpeedPipeline {
 public:
  /// `threads` in all.
  SpeedPipeline(int threads, bool side_by_side, const DetectorParameters& detector,
                const OdometryParameters& odometry);

  /// The next scan; how long it took is kept where `count`.
  void add(const std::shared_ptr<const LidarScan>& scan, bool count);

  [[nodiscard]] int threads() const { return threads_; }
  [[nodiscard]] bool side_by_side() const { return side_by_side_; }
  /// Of every scan counted. Processor time is that of this thread, or of the busier one of the two.
  [[nodiscard]] const std::vector<BusyTime>& times() const { return times_; }
  [[nodiscard]] const std::vector<BusyTime>& odometry_times() const { return odometry_times_; }

 private:
  void register_scan(const std::shared_ptr<const LidarScan>& scan);
  void after_one_another(const std::shared_ptr<const LidarScan>& scan);
  void beside_each_other(const std::shared_ptr<const LidarScan>& scan);

  int threads_;
  bool side_by_side_;
  Detector detector_;
  LidarOdometry odometry_;
  tbb::task_arena arena_, odometry_arena_{1};
  std::vector<BusyTime> times_, odometry_times_;
  BusyTime odometry_time_, side_time_;  // of the newest scan
  // Of the scan before, not detected in yet:
  std::shared_ptr<const LidarScan> before_;
  std::optional<GaussianProcessTrajectory> motion_before_;
  SideThread side_;
};

}  // namespace mapless::app
