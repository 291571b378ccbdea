#pragma once

#include <chrono>
#include <utility>

namespace mapless::inline v1 {

/// Adds its own life to `seconds`, by a steady clock.
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

/// Runs `step` and adds how long it took to `seconds`.
template <class Step>
decltype(auto) timed(double& seconds, Step&& step) {
  const WallTime wall(seconds);
  return std::forward<Step>(step)();
}

}  // namespace mapless
