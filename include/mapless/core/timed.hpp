#pragma once

#include <chrono>
#include <utility>

namespace mapless::inline v1 {

/// Adds the time from its construction to its destruction to `seconds` (steady clock).
class WallTime {
 public:
  explicit WallTime(double& seconds) : seconds_(seconds) {}
  ~WallTime() {
    seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }
  WallTime(const WallTime&) = delete;
  WallTime& operator=(const WallTime&) = delete;

 private:
  double& seconds_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// Runs `step`, adds its duration to `seconds` and returns its result.
template <class Step>
decltype(auto) timed(double& seconds, Step&& step) {
  const WallTime wall(seconds);
  return std::forward<Step>(step)();
}

}  // namespace mapless
