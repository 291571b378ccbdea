#pragma once

#include <cstddef>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "run/input_output_report.hpp"
#include "run/motion_source.hpp"
#include "run/real_time_pace.hpp"
#include "run/run_summary.hpp"
#include "run/scan_reader.hpp"
#include "run/side_thread.hpp"
#include "run/worker_thread.hpp"
#include "terminal/progress.hpp"
#include <mapless/detection/detector.hpp>
#include <mapless/io/dataset.hpp>
#include <mapless/io/object_tables.hpp>
#include <mapless/io/result_folder.hpp>

namespace mapless::app {

/// The scans of a recording that a run is about.
struct ScanSelection {
  std::size_t first = 0;
  std::size_t count = 0;
};

/// One run: scans in, files out. Scans are read ahead on one thread and what is found is written on another.
/// Where the motion is estimated, odometry of a scan goes on beside the detection of the one before; what
/// that finds moving leaves odometry's map after the scan, on one thread as well as on two. Memory is
/// bounded, and the files are the same however the threads run.
class DetectionRun {
 public:
  /// Detects on a thread beside that of odometry where `side_by_side`. At `pace`, where there is one, else as
  /// fast as can be. `make_folder` is called once there is a scan to
  /// write. What is referred to outlives the run.
  DetectionRun(const Dataset& dataset, MotionSource& motion, const ResultFolder& result,
               const DetectorParameters& parameters, RunSummary& summary, ScanSelection selection,
               bool side_by_side, std::optional<RealTimePace> pace, std::function<void()> make_folder);

  /// False where it was interrupted. Throws what reading, detecting or writing threw. Either way what was
  /// finished before is written, what was not is not, and nothing goes on.
  bool run();

  /// Poses and summary of the scans written; nothing where not one was. After `run`.
  void write_outcome();

 private:
  struct FinishedScan {
    std::size_t k = 0;
    std::shared_ptr<const Detection> detection;
    std::vector<TimedPose> poses;  // within it
  };

  [[nodiscard]] InputScan read(std::size_t k) const;
  bool detect_all();
  bool detect_scans();
  [[nodiscard]] std::optional<std::size_t> next_scan();
  [[nodiscard]] std::shared_ptr<const LidarScan> take(std::size_t k);
  void begin_detection(const std::vector<std::shared_ptr<const LidarScan>>& scans);
  void end_detection();
  void finish_scan(Detection detection, const Trajectory& trajectory);
  void write(const FinishedScan& scan);

  const Dataset& dataset_;
  MotionSource& motion_;
  const ResultFolder& result_;
  ScanSelection selection_;
  std::function<void()> make_folder_;

  // The thread that calls run.
  std::optional<RealTimePace> pace_;
  std::size_t next_ = 0;           // where there is no pace
  std::deque<std::size_t> taken_;  // numbers of the scans whose motion is not known
  std::deque<Time> unfinished_;    // starts of the scans not detected in yet
  bool detecting_ = false;
  bool input_known_ = false;
  InputOutputReport input_output_;

  // The one that detects, from begin_detection to end_detection.
  Detector detector_;
  std::deque<std::size_t> numbers_;                      // of the scans in the detector
  std::vector<std::shared_ptr<const Detection>> found_;  // since the last end_detection

  // The thread that writes, until it is joined.
  RunSummary& summary_;
  Progress progress_;
  std::optional<ObjectTableWriter> objects_;  // where the folder is made
  std::vector<TimedPose> poses_, rows_;       // at the start of each scan, and within it
  Time last_end_;

  ScanReader reader_;
  WorkerThread<FinishedScan> writer_;
  std::optional<SideThread> side_;
};

}  // namespace mapless::app
