#pragma once

#include <chrono>
#include <utility>

namespace mapless::app {

/// Runs `step` and tells how long it took [ms].
template <class Step>
double milliseconds_of(Step&& step) {
  const auto start = std::chrono::steady_clock::now();
  std::forward<Step>(step)();
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace mapless::app
