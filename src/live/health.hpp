#pragma once

#include <cstddef>
#include <deque>
#include <map>
#include <string>
#include <vector>

#include <mapless/core/time.hpp>
#include <mapless/live/live_output.hpp>

namespace mapless::inline v1 {

/// What is wrong now, and what happened. A condition is reported each time it is met and is over once it was
/// not met for kLasting. Not thread-safe.
class Health {
 public:
  /// Diagnostics are published once a second: each condition is in two of them at least.
  static constexpr double kLasting_s = 2;

  /// `kind`: of the condition, a few words; `text`: with its figures. The first of its kind becomes an event.
  void report(LiveLevel level, const std::string& kind, std::string text, Time now);
  void add_event(LiveLevel level, std::string text);
  [[nodiscard]] std::vector<LiveEvent> take_events();

  /// The worst level of the conditions that hold, and their texts.
  [[nodiscard]] LiveLevel level(Time now) const;
  [[nodiscard]] std::string message(Time now) const;

 private:
  struct Condition {
    LiveLevel level;
    std::string text;
    Time last;
  };
  [[nodiscard]] static bool holds(const Condition& condition, Time now);

  std::map<std::string, Condition> conditions_;  // by kind
  std::deque<LiveEvent> events_;
};

/// Counts of what happened in the last ten seconds. Not thread-safe.
class RecentTimes {
 public:
  void add(Time now);
  [[nodiscard]] double rate_hz(Time now) const;
  [[nodiscard]] std::size_t count(Time now) const;

 private:
  std::deque<Time> times_;
};

/// Latencies of the last clouds. Not thread-safe.
class Latencies {
 public:
  void add(double latency_s);
  /// The latency [ms] below which `share` of them are; "none" without any.
  [[nodiscard]] std::string percentile_ms(double share) const;

 private:
  std::deque<double> seconds_;
};

}  // namespace mapless
