#pragma once

#include <cstddef>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "reports/duration_histogram.hpp"
#include "reports/json.hpp"
#include "run/result_tables.hpp"
#include "run/worker_thread.hpp"
#include "terminal/progress.hpp"
#include <mapless/io/dataset.hpp>
#include <mapless/io/result_folder.hpp>
#include <mapless/odometry/lidar_odometry.hpp>
#include <mapless/pipeline/online_detector.hpp>

namespace mapless::app {

/// Which poses `mapless odometry` writes.
struct PoseChoice {
  std::string instant = "start";  ///< of each scan: start, middle or end
  int per_scan = 1;               ///< in trajectory.txt, evenly spaced from `instant` on
};

/// One run of the odometry alone: scans in, poses out. The poses of a scan are written, synchronised to the
/// disk, once no later scan changes them: kOpenScans scans later, and those of a start-up with the scan that
/// decides it. Memory is bounded.
class OdometryRun {
 public:
  /// Three later scans correct the knot at the end of a scan, and poses from the middle or end of a scan on
  /// lie within the next.
  static constexpr std::size_t kOpenScans = 4;

  /// `make_folder` is called before the first pose is written. Where an earlier run had finished scans, they
  /// are computed again and compared with its files. Objects passed by reference outlive the run.
  OdometryRun(const Dataset& dataset, const ResultFolder& result, const OdometryParameters& parameters,
              PoseChoice choice, std::function<void()> make_folder, std::size_t finished_before = 0);

  /// LidarOdometry::add_measurement; before run().
  void add_measurement(const MotionMeasurement& measured) { odometry_.add_measurement(measured); }

  /// False where it was interrupted. Throws what reading, estimating or writing threw. Either way the poses
  /// of the scans finished before are written completely, and no thread is left running.
  bool run();

  /// Of the scans processed.
  [[nodiscard]] const OdometryReport& report() const { return report_; }
  /// What contradicts in them: ScanWatch::lines.
  [[nodiscard]] std::vector<std::string> scan_doubts() const { return watch_.lines(); }
  /// Number of scans whose poses are written, of rows in trajectory.txt, and the times of the odometry alone;
  /// after run().
  [[nodiscard]] std::size_t scans() const { return scans_written_; }
  [[nodiscard]] Json json() const;
  /// Milliseconds of the median scan, without reading; 0 without scans.
  [[nodiscard]] double median_ms() const;

 private:
  struct OpenScan {
    std::size_t k = 0;
    Time start, instant;
    Duration length;
    OdometryUpdate update;  // without its knots
  };

  bool process_all();
  void process(std::size_t k);
  void write_settled();
  void write_front();
  void write(const TableRows& rows);
  void finish(bool complete);

  const Dataset& dataset_;
  const ResultFolder& result_;
  PoseChoice choice_;
  std::function<void()> make_folder_;
  std::size_t finished_before_;

  // The thread that calls run.
  ScanWatch watch_;
  LidarOdometry odometry_;
  OdometryReport report_;
  std::deque<OpenScan> open_;  // poses not written yet, in order
  DurationHistogram durations_, processor_times_;
  Progress progress_;

  // The thread that writes, until it is joined.
  std::optional<ResultTables> tables_;  // once the folder is made
  std::size_t scans_written_ = 0;
  Time last_pose_;
  WorkerThread<std::unique_ptr<const TableRows>> writer_;
};

}  // namespace mapless::app
