#include "live/cloud_queue.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace mapless::inline v1 {
namespace {

// The publisher may change after this time without clouds: five turns at 10 Hz are no accident.
constexpr double kTakeOverAfter_s = 0.5;
// The second smallest of eight distances: neither lost clouds nor one early stamp move it.
constexpr std::size_t kStampsOfPeriod = 9;
constexpr std::size_t kFewestStamps = 3;

}  // namespace

CloudQueue::CloudQueue(const LiveParameters& parameters, std::string topic)
    : parameters_(parameters), topic_(std::move(topic)) {}

void CloudQueue::add(PointCloud2 cloud, std::uint64_t publisher, Time now, Health& health) {
  if (!is_of_own_publisher(publisher, now, health)) return;
  if (cloud.view.stamp.nanoseconds() == 0) {
    cloud.view.stamp = now;
    stamps_are_arrivals_ = true;
    health.report(LiveLevel::warning, "no stamp",
                  "the clouds have no stamp: the time of their arrival is used", now);
  }
  last_arrival_ = now;
  ++arrived_;
  recent_.add(now);
  stamps_.push_back(cloud.view.stamp);
  if (stamps_.size() > kStampsOfPeriod) stamps_.pop_front();
  waiting_.push_back({std::move(cloud), now});
  const int limit = starting_ ? std::max(parameters_.start_queue_clouds, parameters_.queue_clouds)
                              : parameters_.queue_clouds;
  if (waiting_.size() > static_cast<std::size_t>(limit)) drop_oldest(now, health);
}

std::optional<Arrival> CloudQueue::take() {
  if (waiting_.empty()) return std::nullopt;
  std::optional<Arrival> oldest(std::move(waiting_.front()));
  waiting_.pop_front();
  return oldest;
}

void CloudQueue::end_start(Time now, Health& health) {
  starting_ = false;
  const std::size_t keep = static_cast<std::size_t>(parameters_.queue_clouds);
  const std::size_t count = waiting_.size();
  if (count <= keep) return;
  std::deque<Arrival> kept;
  for (std::size_t i = 1; i <= keep; ++i) kept.push_back(std::move(waiting_[i * count / keep - 1]));
  waiting_ = std::move(kept);
  for (std::size_t i = keep; i < count; ++i) count_dropped(now);
  report_overload(now, health);
}

void CloudQueue::catch_up(Time now, Health& health) {
  starting_ = waiting_.size() > static_cast<std::size_t>(parameters_.queue_clouds);
  if (!starting_) return;
  waiting_.pop_front();
  count_dropped(now);
  ++dropped_at_start_;
  health.report(LiveLevel::warning, "start",
                fmt::format("the start took long: {} of the clouds that came meanwhile were dropped, every "
                            "other one",
                            dropped_at_start_),
                now);
}

std::optional<Duration> CloudQueue::period() const {
  if (stamps_.size() < kFewestStamps) return std::nullopt;
  std::vector<std::int64_t> distances;
  for (std::size_t i = 1; i < stamps_.size(); ++i)
    distances.push_back((stamps_[i] - stamps_[i - 1]).nanoseconds());
  // Clouds that are lost on their way make distances longer, never shorter.
  std::sort(distances.begin(), distances.end());
  const std::int64_t period_ns = distances[distances.size() / 8];
  return period_ns > 0 ? std::optional(Duration::from_nanoseconds(period_ns)) : std::nullopt;
}

std::optional<Time> CloudQueue::current_stamp(Time now) const {
  if (silence(now)) return std::nullopt;
  return stamps_.back() + Duration::from_seconds(parameters_.clock_offset_s);
}

std::optional<LiveEvent> CloudQueue::silence(Time now) const {
  if (!last_arrival_) return LiveEvent{LiveLevel::warning, fmt::format("no cloud yet on topic {}", topic_)};
  const double silent_s = (now - *last_arrival_).seconds();
  if (silent_s <= parameters_.max_gap_s) return std::nullopt;
  return LiveEvent{
      LiveLevel::error,
      fmt::format("no cloud on topic {} for {:.1f} s: see sensor, cable and driver", topic_, silent_s)};
}

std::string CloudQueue::jump(Duration step) const {
  if (step.seconds() < -parameters_.max_gap_s)
    return fmt::format("the stamps jumped back by {:.3f} s", -step.seconds());
  if (step.seconds() > parameters_.max_gap_s)
    return fmt::format("no cloud for {:.3f} s by the stamps", step.seconds());
  return "";
}

bool CloudQueue::period_settled() const { return !stamps_are_arrivals_ && stamps_.size() >= kStampsOfPeriod; }

bool CloudQueue::is_of_own_publisher(std::uint64_t publisher, Time now, Health& health) {
  if (publisher == publisher_) return true;
  const bool silent = !last_arrival_ || (now - *last_arrival_).seconds() > kTakeOverAfter_s;
  if (publisher_ != 0 && !silent) {
    ++ignored_;
    health.report(
        LiveLevel::warning, "second publisher",
        fmt::format("a second publisher on topic {}: its clouds are ignored ({} so far); stop one of "
                    "the two",
                    topic_, ignored_),
        now);
    return false;
  }
  if (publisher_ != 0)
    health.add_event(LiveLevel::warning,
                     fmt::format("the clouds on topic {} come from another publisher now: the driver has "
                                 "started again",
                                 topic_));
  publisher_ = publisher;
  return true;
}

void CloudQueue::drop_oldest(Time now, Health& health) {
  waiting_.pop_front();
  count_dropped(now);
  report_overload(now, health);
}

void CloudQueue::count_dropped(Time now) {
  ++dropped_;
  recently_dropped_.add(now);
}

void CloudQueue::report_overload(Time now, Health& health) const {
  health.report(
      LiveLevel::warning, "overload",
      fmt::format("overload: {} of the {} clouds of the last 10 s were dropped; give more cores, or "
                  "lower the sensor's rate",
                  recently_dropped_.count(now), recent_.count(now)),
      now);
}

}  // namespace mapless
