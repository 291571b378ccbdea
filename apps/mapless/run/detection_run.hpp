#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "run/input_output_report.hpp"
#include "run/real_time_pace.hpp"
#include "run/result_tables.hpp"
#include "run/run_summary.hpp"
#include "run/scan_reader.hpp"
#include "run/worker_thread.hpp"
#include "terminal/progress.hpp"
#include <mapless/io/dataset.hpp>
#include <mapless/io/result_folder.hpp>
#include <mapless/pipeline/online_detector.hpp>

namespace mapless::app {

/// The scans of a recording to be processed.
struct ScanSelection {
  std::size_t first = 0;
  std::size_t count = 0;
  std::size_t own_vehicle_from = 0;  ///< the own vehicle is learnt from these scans on; at most `first`
};

/// One run: scans in, files out. One thread reads scans ahead and one writes results, beside the
/// OnlineDetector. Memory is bounded, and the files are the same for any number of threads.
class DetectionRun {
 public:
  /// `given`: the trajectory; null: lidar odometry estimates it. With `pace` scans are processed when they
  /// are due, else as fast as possible. `make_folder` is called before the first result is written. Objects
  /// passed by reference outlive the run.
  DetectionRun(const Dataset& dataset, std::shared_ptr<const Trajectory> given, const ResultFolder& result,
               const OnlineDetectorOptions& options, RunSummary& summary, ScanSelection selection,
               std::optional<RealTimePace> pace, std::function<void()> make_folder,
               std::size_t finished_before = 0);

  /// OnlineDetector::add_measurement; before run().
  void add_measurement(const MotionMeasurement& measured) { online_.add_measurement(measured); }

  /// Writes the file of probabilities of each scan, too; before run().
  void write_probabilities() { probabilities_ = true; }

  /// False where it was interrupted. Throws what reading, detecting or writing threw. Either way the results
  /// of scans finished before are written completely, and no thread is left running.
  bool run();

  /// Writes the last poses and the summary of the scans written; nothing where there are none, or not more
  /// than the earlier run had finished. After `run`.
  void write_outcome();

  /// The states of the motion; without scans where poses are given.
  [[nodiscard]] const OdometryReport& odometry_report() const { return online_.odometry_report(); }

 private:
  struct FinishedScan {
    std::size_t k = 0;  // of the recording
    LabelledScan labelled;
    std::vector<TimedPose> poses;  // within it
  };

  [[nodiscard]] InputScan read(std::size_t k);
  void learn_own_vehicle();
  bool detect_all();
  bool push_all();
  [[nodiscard]] std::optional<std::size_t> next_scan();
  [[nodiscard]] bool next_is_ready() const;
  [[nodiscard]] std::shared_ptr<const LidarScan> take(std::size_t k);
  void finish(std::vector<LabelledScan> scans);
  void write(const FinishedScan& scan);
  void verify(std::size_t k, const ScanFiles& files);

  const Dataset& dataset_;
  std::shared_ptr<const Trajectory> given_;
  const ResultFolder& result_;
  ScanSelection selection_;
  std::function<void()> make_folder_;
  std::size_t finished_before_;
  bool probabilities_ = false;

  // The thread that calls run.
  OnlineDetector online_;
  std::optional<RealTimePace> pace_;
  std::size_t next_ = 0;             // index in the selection, where there is no pace
  std::deque<std::size_t> numbers_;  // of the scans pushed and not labelled yet
  bool input_known_ = false;
  InputOutputReport input_output_;

  // The thread that writes, until it is joined.
  RunSummary& summary_;
  Progress progress_;
  std::optional<ResultTables> tables_;                 // once the folder is made
  std::shared_ptr<const Trajectory> last_trajectory_;  // of the last scan finished
  Time last_end_;

  ScanWatch watch_;  // of the thread that reads, until it is stopped
  ScanReader reader_;
  WorkerThread<FinishedScan> writer_;
};

}  // namespace mapless::app
