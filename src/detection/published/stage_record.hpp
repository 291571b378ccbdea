#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include <mapless/detection/stages.hpp>

namespace mapless::inline v1 {

/// One element per point: whether it is dynamic once `stage` is done.
inline std::vector<char> dynamic_points(const std::vector<StageTrace>& trace, Stage stage) {
  std::vector<char> dynamic(trace.size());
  std::transform(trace.begin(), trace.end(), dynamic.begin(),
                 [stage](const StageTrace& t) { return static_cast<char>(dynamic_after(t, stage)); });
  return dynamic;
}

/// Enters the verdicts of one stage, one per point.
template <class Verdict>
void record(std::vector<StageTrace>& trace, Verdict StageTrace::*stage,
            const std::vector<Verdict>& verdicts) {
  for (std::size_t i = 0; i < trace.size(); ++i) trace[i].*stage = verdicts[i];
}

}  // namespace mapless
