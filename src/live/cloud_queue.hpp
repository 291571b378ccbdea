#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>

#include "live/health.hpp"
#include <mapless/core/time.hpp>
#include <mapless/live/live_options.hpp>
#include <mapless/live/point_cloud2.hpp>

namespace mapless::inline v1 {

/// A cloud that has arrived.
struct Arrival {
  PointCloud2 cloud;
  Time arrived;
};

/// The clouds that wait for detection, of one publisher. Bounded: where it is full, the oldest cloud goes, so
/// that under a lasting overload the clouds that are processed are evenly spaced. Not thread-safe.
class CloudQueue {
 public:
  CloudQueue(const LiveParameters& parameters, std::string topic);

  void add(PointCloud2 cloud, std::uint64_t publisher, Time now, Health& health);
  [[nodiscard]] std::optional<Arrival> take();
  [[nodiscard]] bool empty() const { return waiting_.empty(); }
  [[nodiscard]] std::size_t waiting() const { return waiting_.size(); }

  /// From now on the longer queue holds, until end_start.
  void begin_start() {
    starting_ = true;
    dropped_at_start_ = 0;
  }
  [[nodiscard]] bool starting() const { return starting_; }
  /// The clouds that do not fit into the shorter queue go, evenly spaced.
  void end_start(Time now, Health& health);
  /// Before each take() once labels come: while more clouds wait than fit into the shorter queue, every other
  /// one goes; then the start is over. Own odometry then has scans two turns apart at most.
  void catch_up(Time now, Health& health);

  /// Of the last clouds that arrived, by the second smallest distance of their stamps; none before there are
  /// three, and where they do not increase.
  [[nodiscard]] std::optional<Duration> period() const;
  /// Whether period() is of as many clouds as it will ever be; never of clouds without a stamp, whose
  /// arrivals are early and late.
  [[nodiscard]] bool period_settled() const;

  /// Why a cloud `step` after the last cannot belong to the same drive; empty where it can. Any thread.
  [[nodiscard]] std::string jump(Duration step) const;

  [[nodiscard]] std::optional<Time> last_arrival() const { return last_arrival_; }
  /// The stamp of the cloud that arrived last, on the clock of the other inputs (clock_offset_s); none where
  /// that is longer ago than max_gap_s.
  [[nodiscard]] std::optional<Time> current_stamp(Time now) const;
  /// That no cloud has come for longer than max_gap_s, or none yet; none where clouds come.
  [[nodiscard]] std::optional<LiveEvent> silence(Time now) const;
  [[nodiscard]] std::size_t arrived() const { return arrived_; }
  [[nodiscard]] std::size_t dropped() const { return dropped_; }
  [[nodiscard]] std::size_t ignored() const { return ignored_; }
  [[nodiscard]] const RecentTimes& recent() const { return recent_; }

 private:
  [[nodiscard]] bool is_of_own_publisher(std::uint64_t publisher, Time now, Health& health);
  void drop_oldest(Time now, Health& health);
  void count_dropped(Time now);
  void report_overload(Time now, Health& health) const;

  LiveParameters parameters_;
  std::string topic_;
  std::deque<Arrival> waiting_;
  std::deque<Time> stamps_;
  bool starting_ = true, stamps_are_arrivals_ = false;
  std::uint64_t publisher_ = 0;
  std::optional<Time> last_arrival_;
  std::size_t arrived_ = 0, dropped_ = 0, ignored_ = 0, dropped_at_start_ = 0;
  RecentTimes recent_, recently_dropped_;
};

}  // namespace mapless
