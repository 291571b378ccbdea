#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "reports/json.hpp"
#include <mapless/core/time.hpp>
#include <mapless/io/dataset.hpp>

namespace mapless::app {

/// The clock of a run in real time; tests give their own.
struct Clock {
  std::function<Time()> now;
  std::function<void(Time)> sleep_until;
};

/// The steady clock of the computer.
[[nodiscard]] Clock machine_clock();

/// How well a run kept up with a recording played at its own pace.
struct RealTimeReport {
  std::size_t scans = 0;           ///< arrived
  std::size_t late = 0;            ///< processed, but after waiting for the scans before them
  std::size_t dropped = 0;         ///< never processed: newer scans filled the queue
  std::vector<double> latency_ms;  ///< from the last ray of a scan to its labels, of the scans processed
};

/// Plays a recording at its own pace: a scan arrives when its last ray was measured, counted from the start
/// of the first scan. Scans that arrive during the processing of another wait in a queue of kQueue, the depth
/// of ROS 2's sensor-data profile; where it is full, the oldest scan in it is dropped.
class RealTimePace {
 public:
  static constexpr std::size_t kQueue = 5;

  /// `ends`: when the last ray of each scan was measured, increasing; `begin`: when the first was.
  RealTimePace(Time begin, std::vector<Time> ends, Clock clock);

  /// Index of the next scan to process; sleeps until it arrives. Nothing after the last scan, or once `stop`
  /// returns true. The first call starts the recording.
  [[nodiscard]] std::optional<std::size_t> next(const std::function<bool()>& stop);
  /// True where the next scan has arrived already. After the first `next`.
  [[nodiscard]] bool next_is_due() const;
  /// Takes the time at which the labels of this scan are ready.
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

/// The pace of the scans [first, first + count) on machine_clock().
[[nodiscard]] RealTimePace pace_of(const Dataset& dataset, std::size_t first, std::size_t count);

[[nodiscard]] Json to_json(const RealTimeReport& report);
/// The same as a line of text.
[[nodiscard]] std::string text_of(const RealTimeReport& report);

}  // namespace mapless::app
