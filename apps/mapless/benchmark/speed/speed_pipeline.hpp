#pragma once

#include <memory>
#include <vector>

#include <tbb/task_arena.h>

#include "run/busy_time.hpp"
#include <mapless/pipeline/online_detector.hpp>

namespace mapless::app {

/// Measures the time per scan of an OnlineDetector with lidar odometry.
class SpeedPipeline {
 public:
  /// `threads` in all. With `side_by_side`, one of them does the odometry and the others the detection.
  SpeedPipeline(int threads, bool side_by_side, const DetectorParameters& detector,
                const OdometryParameters& odometry);

  /// Processes the next scan; keeps its time if `count`.
  void add(const std::shared_ptr<const LidarScan>& scan, bool count);

  [[nodiscard]] int threads() const { return threads_; }
  [[nodiscard]] bool side_by_side() const { return side_by_side_; }
  /// Of every scan counted. Processor time is that of the calling thread, or of all others together where
  /// that is more.
  [[nodiscard]] const std::vector<BusyTime>& times() const { return times_; }

 private:
  int threads_;
  bool side_by_side_;
  OnlineDetector online_;
  tbb::task_arena arena_;
  std::vector<BusyTime> times_;
};

}  // namespace mapless::app
