#include "live/figures.hpp"

#include <fmt/format.h>

namespace mapless::inline v1 {

void Figures::add(const LiveOutput& output, bool timed, Time now) {
  ++labelled;
  labelled_times.add(now);
  if (timed) latencies.add(output.latency_s);
  motion = name_of(output.labelled.motion_state());
}

std::vector<std::pair<std::string, std::string>> Figures::values(const CloudQueue& queue, Time now) const {
  return {{"motion", motion},
          {"input_rate_hz", fmt::format("{:.2f}", queue.recent().rate_hz(now))},
          {"output_rate_hz", fmt::format("{:.2f}", labelled_times.rate_hz(now))},
          {"start_s", start_s},
          {"latency_median_ms", latencies.percentile_ms(0.5)},
          {"latency_p99_ms", latencies.percentile_ms(0.99)},
          {"latency_max_ms", latencies.percentile_ms(1)},
          {"clouds", std::to_string(queue.arrived())},
          {"labelled", std::to_string(labelled)},
          {"waiting", std::to_string(queue.waiting())},
          {"dropped", std::to_string(queue.dropped())},
          {"unusable", std::to_string(refused)},
          {"of_second_publisher", std::to_string(queue.ignored())},
          {"measurements", std::to_string(measurements)}};
}

}  // namespace mapless
