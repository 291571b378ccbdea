#pragma once

/// @file
/// Folder explain: why a point of a result is dynamic or static. In go a recording and the result of mapless
/// detect; the detector runs again and records how it decides (ScanExplanation); out come texts, JSON, and
/// the blocks of which the page of `mapless view` explains points. Nothing here decides.

#include <cstddef>
#include <functional>
#include <string>

#include "options/motion_measurements.hpp"
#include "options/parameter_options.hpp"
#include <mapless/io/dataset.hpp>
#include <mapless/io/result_folder.hpp>
#include <mapless/io/trajectory_file.hpp>
#include <mapless/pipeline/online_detector.hpp>

namespace mapless::app {

/// The poses and measurements that the run was given on the command line; those of the recording need none.
struct GivenAgain {
  TrajectoryRequest trajectory;
  MotionMeasurementOptions measured;
};

/// The run of mapless detect that made a result, once more: the same recording, options and order of scans,
/// hence the same labels. Labels depend on all scans before, so it begins with the first scan of the run.
class ReplayedRun {
 public:
  /// Keeps references. Throws ParameterError and InputError where the result is not one of mapless detect,
  /// was made by another version or method "published", or where recording or poses differ from those of the
  /// run.
  ReplayedRun(const Dataset& dataset, const ResultFolder& result, const GivenAgain& given);

  /// Number of the first scan of the run in the recording, and how many it has.
  [[nodiscard]] std::size_t first() const { return first_; }
  [[nodiscard]] std::size_t count() const { return count_; }
  [[nodiscard]] const RunParameters& parameters() const { return parameters_; }

  /// Labels all scans up to number `last`, in order, and calls `take` for each of them. Points are explained
  /// where `explained` says so. Throws InputError where a label differs from that of the result.
  void run(std::size_t last, const std::function<bool(std::size_t)>& explained,
           const std::function<void(std::size_t, const LabelledScan&)>& take) const;

 private:
  void require_same_labels(std::size_t k, const LabelledScan& scan) const;

  const Dataset& dataset_;
  const ResultFolder& result_;
  RunParameters parameters_;
  std::size_t first_ = 0, count_ = 0;
  std::shared_ptr<const Trajectory> trajectory_;  // null: estimated
  std::vector<MotionMeasurement> measured_;
};

}  // namespace mapless::app
