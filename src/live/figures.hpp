#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "live/cloud_queue.hpp"
#include "live/health.hpp"
#include <mapless/core/time.hpp>
#include <mapless/live/live_output.hpp>

namespace mapless::inline v1 {

/// What the diagnostics state of the labels. Not thread-safe.
struct Figures {
  Latencies latencies;
  RecentTimes labelled_times;
  std::size_t labelled = 0, refused = 0, measurements = 0;
  std::string motion = "unknown", start_s = "none";

  /// `timed`: its latency counts.
  void add(const LiveOutput& output, bool timed, Time now);
  /// With those of the clouds.
  [[nodiscard]] std::vector<std::pair<std::string, std::string>> values(const CloudQueue& queue,
                                                                        Time now) const;
};

}  // namespace mapless
