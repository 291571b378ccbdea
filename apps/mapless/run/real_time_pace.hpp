#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include <mapless/core/time.hpp>
#include <mapless/io/dataset.hpp>

namespace mapless::app {

/// What tells the time to a run that keeps time; a test gives its own.
struct Clock {
  std::function<Time()> now;
  std::function<void(Time)> sleep_until;
};

/// The steady one of the machine.
[[nodiscard]] Clock machine_clock();

/// How a run kept up with a recording played at its own pace.
struct RealTimeReport {
  std::size_t scans = 0;           ///< that came
  std::size_t late = 0;            ///< had to wait for the scans before them, and were answered
  std::size_t dropped = 0;         ///< never looked at: newer ones filled the queue
  std::vector<double> latency_ms;  ///< from the last ray of a scan to its labels, of those answered
};

/// Plays a recording at its own pace: a scan is there when its last ray was measured, counted from the first
/// scan's start. Scans that come while one is worked on wait in a queue of the last kQueue, as with a ROS
/// driver of the sensor-data profile: where more come, the oldest waiting is dropped.
class RealTimePace {
 public:
  static constexpr std::size_t kQueue = 5;

  /// `ends`: when the last ray of each scan was measured, increasing; `begin`: when the first was.
  RealTimePace(Time begin, std::vector<Time> ends, Clock clock);

  /// Index of the next scan to work on, slept for where none waits. Nothing after the last scan, or once
  /// `stop` says so. The first call starts the recording.
  [[nodiscard]] std::optional<std::size_t> next(const std::function<bool()>& stop);
  /// True where the next scan has arrived already. After the first `next`.
  [[nodiscard]] bool next_is_due() const;
  /// The labels of this scan are there.
  void answered(std::size_t index);

  [[nodiscard]] const RealTimeReport& report() const { return report_; }

 private:
  [[nodiscard]] Time due(std::size_t index) const;

  Time begin_;
  std::vector<Time> ends_;
  Clock clock_;
  std::optional<Time> started_;
  std::size_t next_ = 0;     // the oldest scan that waits or is still to come
  std::size_t arrived_ = 0;  // scans that came so far
  RealTimeReport report_;
};

/// The pace of the scans [first, first + count) on the machine's clock.
[[nodiscard]] RealTimePace pace_of(const Dataset& dataset, std::size_t first, std::size_t count);

[[nodiscard]] nlohmann::ordered_json to_json(const RealTimeReport& report);
/// A line for people.
[[nodiscard]] std::string text_of(const RealTimeReport& report);

}  // namespace mapless::app
