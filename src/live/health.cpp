#include "live/health.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

#include <fmt/format.h>

namespace mapless::inline v1 {
namespace {

// Where nobody takes them, the oldest go.
constexpr std::size_t kMostEvents = 100;
constexpr double kWindow_s = 10;
// A minute at 10 Hz.
constexpr std::size_t kLatencies = 600;

}  // namespace

bool Health::holds(const Condition& condition, Time now) {
  return (now - condition.last).seconds() < kLasting_s;
}

void Health::report(LiveLevel level, const std::string& kind, std::string text, Time now) {
  const auto found = conditions_.find(kind);
  if (found == conditions_.end() || !holds(found->second, now)) add_event(level, text);
  conditions_[kind] = {level, std::move(text), now};
}

void Health::add_event(LiveLevel level, std::string text) {
  events_.push_back({level, std::move(text)});
  if (events_.size() > kMostEvents) events_.pop_front();
}

std::vector<LiveEvent> Health::take_events() {
  const std::deque<LiveEvent> events = std::exchange(events_, {});
  return {events.begin(), events.end()};
}

LiveLevel Health::level(Time now) const {
  LiveLevel worst = LiveLevel::ok;
  for (const auto& [kind, condition] : conditions_) {
    if (holds(condition, now)) worst = std::max(worst, condition.level);
  }
  return worst;
}

std::string Health::message(Time now) const {
  std::vector<std::string> texts;
  for (const auto& [kind, condition] : conditions_) {
    if (holds(condition, now)) texts.push_back(condition.text);
  }
  return fmt::format("{}", fmt::join(texts, "; "));
}

void RecentTimes::add(Time now) {
  times_.push_back(now);
  while ((now - times_.front()).seconds() > kWindow_s) times_.pop_front();
}

std::size_t RecentTimes::count(Time now) const {
  return static_cast<std::size_t>(
      std::count_if(times_.begin(), times_.end(), [&](Time t) { return (now - t).seconds() <= kWindow_s; }));
}

double RecentTimes::rate_hz(Time now) const {
  const std::size_t n = count(now);
  if (n < 2) return 0;
  const Time first = times_[times_.size() - n];
  const double span_s = (times_.back() - first).seconds();
  return span_s > 0 ? static_cast<double>(n - 1) / span_s : 0;
}

void Latencies::add(double latency_s) {
  seconds_.push_back(latency_s);
  if (seconds_.size() > kLatencies) seconds_.pop_front();
}

std::string Latencies::percentile_ms(double share) const {
  if (seconds_.empty()) return "none";
  std::vector<double> sorted(seconds_.begin(), seconds_.end());
  std::sort(sorted.begin(), sorted.end());
  return fmt::format("{:.1f}",
                     1e3 * sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))]);
}

}  // namespace mapless
