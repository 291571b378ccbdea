#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "reports/duration_histogram.hpp"
#include "reports/json.hpp"
#include "reports/json_text.hpp"
#include "run/input_output_report.hpp"
#include "run/real_time_pace.hpp"
#include <mapless/detection/detector.hpp>
#include <mapless/io/dataset.hpp>
#include <mapless/io/trajectory_file.hpp>
#include <mapless/pipeline/online_detector.hpp>

namespace mapless::app {

/// The lines of `found`, by ScanWatch, about what no line of `said`, of the self-check of the input, is
/// about.
[[nodiscard]] std::vector<std::string> further_doubts(const std::vector<std::string>& said,
                                                      const std::vector<std::string>& found);

/// Number of durations in summary.json: one per step of the method, and their total.
inline constexpr std::size_t kTimings = 11;

/// Input, settings and results of a run of `mapless detect`: the contents of summary.json.
class RunSummary {
 public:
  RunSummary(const Dataset& dataset, std::string recording, const TrajectorySource& trajectory,
             std::string profile, std::size_t first_scan, std::size_t selected_scans);

  /// Where the times and rings of the scans come from, and whether motion compensation was undone.
  void set_input(const LidarScan& scan, bool was_compensated);
  /// See recording_digest in run/earlier_run.hpp.
  void set_recording_digest(std::string digest) { recording_digest_ = std::move(digest); }
  /// Whether the run writes probabilities.
  void set_probability(bool probability) { probability_ = probability; }
  /// Number of scans that an earlier run had finished, where this run went on with it.
  void set_resumed_after(std::size_t scans) { resumed_after_ = scans; }
  /// Counts a scan's points, objects and times.
  void add(const Detection& detection);
  void set_odometry(const OdometryReport& report) { odometry_ = report; }
  void set_input_output(const InputOutputReport& report) { input_output_ = report; }
  void set_real_time(const RealTimeReport& report) { real_time_ = report; }
  /// Lines of the self-check of the input.
  void set_input_doubts(std::vector<std::string> lines) { input_doubts_ = std::move(lines); }
  /// Lines of ScanWatch; what the self-check of the input has said is not said again.
  void set_scan_doubts(const std::vector<std::string>& lines);
  void set_complete() { complete_ = true; }
  void set_stopped(std::string reason) { stopped_ = std::move(reason); }

  /// One line; empty where detection did not wait for reading or writing.
  [[nodiscard]] std::string input_output_trouble() const {
    return input_output_ ? trouble(*input_output_) : "";
  }
  /// Why the result is not trustworthy, one line each: input, moving points, motion. None where it is.
  [[nodiscard]] std::vector<std::string> doubts() const;
  [[nodiscard]] std::size_t scans() const { return scans_; }
  [[nodiscard]] Json json() const;
  /// Text of summary.json.
  [[nodiscard]] std::string text() const { return json_text(json()); }
  /// A few lines for the terminal.
  [[nodiscard]] std::string lines() const;

 private:
  void count_id(std::uint32_t id);

  std::string recording_, format_, sensor_, profile_;
  std::vector<std::pair<std::string, std::string>> trajectory_;
  std::vector<std::string> notes_;
  std::size_t first_scan_, selected_scans_;
  std::string recording_digest_;
  bool probability_ = false;
  std::optional<std::size_t> resumed_after_;
  std::string times_, rings_, motion_compensation_;
  std::size_t records_ = 0, points_ = 0, dynamic_points_ = 0, objects_ = 0;
  std::size_t scans_ = 0;
  std::vector<bool> seen_ids_;  // of the moving objects of all scans: one bit an object
  std::size_t ids_ = 0;
  std::array<DurationHistogram, kTimings> durations_;
  MovingShare moving_share_;
  std::vector<std::string> input_doubts_, scan_doubts_;
  std::optional<OdometryReport> odometry_;
  std::optional<InputOutputReport> input_output_;
  std::optional<RealTimeReport> real_time_;
  bool complete_ = false;
  std::string stopped_;
};

/// Median and quantiles of the milliseconds of each step and of their total, by the step's name.
[[nodiscard]] Json timing_json(const std::vector<StageSeconds>& scans);

/// "from the sensor", "recovered from the azimuth" ...
[[nodiscard]] std::string provenance_text(Provenance provenance);

}  // namespace mapless::app
