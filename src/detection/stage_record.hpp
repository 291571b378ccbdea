#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <vector>

#include <mapless/detection/stages.hpp>

namespace mapless {

/// Runs `step` and tells how long it took.
template <class Step>
auto timed(double& seconds, Step&& step) {
  const auto start = std::chrono::steady_clock::now();
  auto result = step();
  seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result;
}

/// One element per point: whether it is dynamic once `stage` is done.
inline std::vector<char> dynamic_points(const std::vector<StageTrace>& trace, Stage stage) {
  std::vector<char> dynamic(trace.size());
  std::transform(trace.begin(), trace.end(), dynamic.begin(),
                 [stage](const StageTrace& t) { return static_cast<char>(dynamic_after(t, stage)); });
  return dynamic;
}

/// Enters what one stage said of every point.
template <class Verdict>
void record(std::vector<StageTrace>& trace, Verdict StageTrace::*stage,
            const std::vector<Verdict>& verdicts) {
  for (std::size_t i = 0; i < trace.size(); ++i) trace[i].*stage = verdicts[i];
}

}  // namespace mapless
