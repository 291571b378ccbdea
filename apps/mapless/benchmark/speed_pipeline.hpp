#pragma once

#include <memory>
#include <optional>
#include <vector>

#include <tbb/task_arena.h>

#include "side_thread.hpp"
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
  [[nodiscard]] const std::vector<double>& milliseconds() const { return milliseconds_; }
  /// Of that, where one comes after the other.
  [[nodiscard]] const std::vector<double>& odometry_ms() const { return odometry_ms_; }

 private:
  void after_one_another(const std::shared_ptr<const LidarScan>& scan, double& odometry_ms);
  void beside_each_other(const std::shared_ptr<const LidarScan>& scan);

  int threads_;
  bool side_by_side_;
  Detector detector_;
  LidarOdometry odometry_;
  tbb::task_arena arena_, odometry_arena_{1};
  std::vector<double> milliseconds_, odometry_ms_;
  // Of the scan before, not detected in yet:
  std::shared_ptr<const LidarScan> before_;
  std::optional<GaussianProcessTrajectory> motion_before_;
  SideThread side_;
};

}  // namespace mapless::app
