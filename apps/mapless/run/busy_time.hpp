#pragma once

#include <ctime>
#include <utility>

#include <mapless/core/time.hpp>

namespace mapless::app {

/// Wall time that a thread spent on a task, and processor time within it; for the rest it waited for the disk
/// or for a processor.
struct BusyTime {
  double wall_s = 0;
  double processor_s = 0;

  [[nodiscard]] double wall_ms() const { return 1e3 * wall_s; }
  [[nodiscard]] double processor_ms() const { return 1e3 * processor_s; }

  /// Adds the time from its construction to its destruction.
  class Measure {
   public:
    explicit Measure(BusyTime& to) : to_(to), wall_(to.wall_s) {}
    ~Measure() { to_.processor_s += processor_seconds() - processor_start_s_; }
    Measure(const Measure&) = delete;
    Measure& operator=(const Measure&) = delete;

   private:
    static double processor_seconds() {
      timespec now = {};
      clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
      return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
    }

    BusyTime& to_;
    WallTime wall_;
    double processor_start_s_ = processor_seconds();
  };
};

/// Runs `step` on this thread and returns its time.
template <class Step>
BusyTime busy_time_of(Step&& step) {
  BusyTime time;
  {
    const BusyTime::Measure measure(time);
    std::forward<Step>(step)();
  }
  return time;
}

}  // namespace mapless::app
