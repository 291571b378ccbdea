#include "run/real_time_pace.hpp"

#include <algorithm>
#include <chrono>
#include <thread>
#include <utility>

#include <fmt/format.h>

#include "reports/json.hpp"
#include <mapless/evaluation/trajectory_evaluation.hpp>

namespace mapless::app {
namespace {

// An interrupt is noticed within this time.
constexpr auto kLongestSleep = Duration::from_nanoseconds(50'000'000);

using SteadyTime = std::chrono::time_point<std::chrono::steady_clock, std::chrono::nanoseconds>;

double milliseconds(Duration duration) { return 1e3 * duration.seconds(); }

}  // namespace

Clock machine_clock() {
  return {[] {
            const SteadyTime now = std::chrono::steady_clock::now();
            return Time::from_nanoseconds(now.time_since_epoch().count());
          },
          [](Time until) {
            std::this_thread::sleep_until(SteadyTime(std::chrono::nanoseconds(until.nanoseconds())));
          }};
}

RealTimePace::RealTimePace(Time begin, std::vector<Time> ends, Clock clock)
    : begin_(begin), ends_(std::move(ends)), clock_(std::move(clock)) {}

Time RealTimePace::due(std::size_t index) const { return *started_ + (ends_[index] - begin_); }

std::optional<std::size_t> RealTimePace::next(const std::function<bool()>& stop) {
  if (!started_) started_ = clock_.now();
  if (next_ == ends_.size()) return std::nullopt;
  Time now = clock_.now();
  const bool waits = due(next_) <= now;
  for (; now < due(next_); now = clock_.now()) {
    if (stop()) return std::nullopt;
    clock_.sleep_until(std::min(due(next_), now + kLongestSleep));
  }
  while (arrived_ < ends_.size() && due(arrived_) <= now) ++arrived_;
  const std::size_t oldest_kept = std::max(next_, arrived_ - std::min(arrived_, kQueue));
  report_.dropped += oldest_kept - std::exchange(next_, oldest_kept);
  report_.scans = arrived_;
  report_.late += waits ? 1 : 0;
  return next_++;
}

bool RealTimePace::next_is_due() const { return next_ < ends_.size() && due(next_) <= clock_.now(); }

void RealTimePace::answered(std::size_t index) {
  report_.latency_ms.push_back(milliseconds(clock_.now() - due(index)));
}

RealTimePace pace_of(const Dataset& dataset, std::size_t first, std::size_t count) {
  std::vector<Time> ends;
  for (std::size_t k = first; k < first + count; ++k) ends.push_back(dataset.scan_end(k));
  return {dataset.scan_start(first), std::move(ends), machine_clock()};
}

Json to_json(const RealTimeReport& r) {
  const auto of = [&](double q) {
    const auto value = quantile(r.latency_ms, q);
    return value ? Json(*value) : Json(nullptr);
  };
  return {
      {"scans", r.scans},
      {"late", r.late},
      {"dropped", r.dropped},
      {"queue", RealTimePace::kQueue},
      {"latency", {{"median_ms", of(0.5)}, {"p95_ms", of(0.95)}, {"p99_ms", of(0.99)}, {"max_ms", of(1)}}}};
}

std::string text_of(const RealTimeReport& r) {
  const auto of = [&](double q) { return quantile(r.latency_ms, q).value_or(0); };
  return fmt::format(
      "in real time: {} of {} scans late (they waited), {} dropped (of more than {} waiting, the oldest); "
      "from the last ray to the labels {:.1f} ms (median), {:.1f} (95 %), {:.1f} (99 %), {:.1f} (max)\n",
      r.late, r.scans, r.dropped, RealTimePace::kQueue, of(0.5), of(0.95), of(0.99), of(1));
}

}  // namespace mapless::app
