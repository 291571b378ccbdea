#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "reports/json_text.hpp"
#include "run/input_output_report.hpp"
#include "run/real_time_pace.hpp"
#include <mapless/detection/detector.hpp>
#include <mapless/io/dataset.hpp>
#include <mapless/io/trajectory_file.hpp>
#include <mapless/pipeline/online_detector.hpp>

namespace mapless::app {

/// Input, settings and results of a run of `mapless detect`: the contents of summary.json.
class RunSummary {
 public:
  RunSummary(const Dataset& dataset, std::string recording, const TrajectorySource& trajectory,
             std::string profile, std::size_t first_scan, std::size_t selected_scans);

  /// Where the times and rings of the scans come from, and whether motion compensation was undone.
  void set_input(const LidarScan& scan, bool was_compensated);
  /// Counts a scan's points, objects and times.
  void add(const Detection& detection);
  void set_odometry(const OdometryReport& report) { odometry_ = report; }
  void set_input_output(const InputOutputReport& report) { input_output_ = report; }
  void set_real_time(const RealTimeReport& report) { real_time_ = report; }
  void set_complete() { complete_ = true; }
  void set_stopped(std::string reason) { stopped_ = std::move(reason); }

  /// One line; empty where detection did not wait for reading or writing.
  [[nodiscard]] std::string input_output_trouble() const {
    return input_output_ ? trouble(*input_output_) : "";
  }
  [[nodiscard]] std::size_t scans() const { return seconds_.size(); }
  [[nodiscard]] nlohmann::ordered_json json() const;
  /// Text of summary.json.
  [[nodiscard]] std::string text() const { return json_text(json()); }
  /// A few lines for the terminal.
  [[nodiscard]] std::string lines() const;

 private:
  std::string recording_, format_, sensor_, profile_;
  std::vector<std::pair<std::string, std::string>> trajectory_;
  std::vector<std::string> notes_;
  std::size_t first_scan_, selected_scans_;
  std::string times_, rings_, motion_compensation_;
  std::size_t records_ = 0, points_ = 0, dynamic_points_ = 0, objects_ = 0;
  std::set<std::uint32_t> ids_;  // of the moving objects of all scans
  std::vector<StageSeconds> seconds_;
  std::optional<OdometryReport> odometry_;
  std::optional<InputOutputReport> input_output_;
  std::optional<RealTimeReport> real_time_;
  bool complete_ = false;
  std::string stopped_;
};

/// Median and quantiles of the milliseconds of each step and of their total, by the step's name.
[[nodiscard]] nlohmann::ordered_json timing_json(const std::vector<StageSeconds>& scans);

/// "from the sensor", "recovered from the azimuth" ...
[[nodiscard]] std::string provenance_text(Provenance provenance);

}  // namespace mapless::app
