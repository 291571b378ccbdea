#include "live/scan_maker.hpp"

#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "core/time_check.hpp"
#include <mapless/core/errors.hpp>

namespace mapless::inline v1 {
namespace {

// As many as the reader of a recording takes.
constexpr std::size_t kCloudsForSensor = 8;
constexpr std::size_t kCloudsForTurn = 3;
// Lidars keep their rate to a percent; stamps of arrival vary by some milliseconds of a turn.
constexpr double kOtherTurn = 0.1;
// A named model is of a sensor at 10 Hz, which most also turn at half and at twice the rate.
constexpr double kTurnFactors[] = {0.5, 1.0, 2.0};

}  // namespace

ScanMaker::ScanMaker(std::optional<LidarModel> sensor, std::string topic, Duration clock_offset)
    : sensor_(std::move(sensor)), topic_(std::move(topic)), clock_offset_(clock_offset) {
  if (sensor_) validate(*sensor_, "sensor");
}

std::vector<MadeScan> ScanMaker::add(Arrival arrival, std::optional<Duration> period, const Refuse& refuse) {
  if (!pattern_) {
    pattern_ = arrival.cloud.view;
    pattern_->data = {};
  }
  kept_.push_back(std::move(arrival));
  std::vector<MadeScan> made;
  if (!builder_ && !prepare(period, refuse)) return made;
  for (Arrival& kept : std::exchange(kept_, {})) {
    if (auto one = make(std::move(kept), refuse)) made.push_back(*std::move(one));
  }
  return made;
}

// False where the sensor is not known yet.
bool ScanMaker::prepare(std::optional<Duration> period, const Refuse& refuse) {
  const std::size_t needed = sensor_ ? kCloudsForTurn : kCloudsForSensor;
  if (kept_.size() < needed || !period) return false;
  try {
    std::vector<DriverFields> fields;
    std::vector<PointFields> points;
    std::vector<Time> stamps;
    for (const Arrival& kept : kept_) {
      fields.push_back(read_point_cloud2(kept.cloud.view, topic_));
      points.push_back(fields.back().fields);
      stamps.push_back(kept.cloud.view.stamp);
    }
    builder_ = sensor_ ? ScanBuilder(*sensor_) : ScanBuilder::recover(points, stamps, topic_);
    notes_ = fields.front().notes;
    for (const std::string& note : builder_->notes()) notes_.push_back(note);
  } catch (const Error& error) {
    refuse(error.what());
    kept_.pop_front();
    return false;
  }
  set_turn(*period);
  return true;
}

void ScanMaker::set_turn(Duration period) {
  turn_ = period;
  const double nominal_s = 1 / builder_->model()->rotation_rate_hz;
  for (const double factor : kTurnFactors) {
    if (std::abs(period.seconds() / (factor * nominal_s) - 1) < kOtherTurn)
      builder_->set_turn_duration(period);
  }
}

std::optional<MadeScan> ScanMaker::make(Arrival arrival, const Refuse& refuse) {
  try {
    const DriverFields fields = read_point_cloud2(arrival.cloud.view, topic_);
    LidarScan scan = builder_->build(fields.fields, arrival.cloud.view.stamp, topic_);
    scan.start = scan.start + clock_offset_;
    require_time("topic " + topic_, "header.stamp + clock_offset_s", scan.start);
    watch_.add(scan, watched_++);
    return MadeScan{std::move(arrival), std::make_shared<const LidarScan>(std::move(scan)),
                    watch_.take_lines()};
  } catch (const Error& error) {
    refuse(error.what());
    return std::nullopt;
  }
}

void ScanMaker::forget_sensor() {
  builder_.reset();
  turn_.reset();
  kept_.clear();
  pattern_.reset();
  notes_.clear();
}

std::string ScanMaker::difference(const PointCloud2View& cloud, std::optional<Duration> period) const {
  if (!pattern_) return "";
  const bool organised = cloud.height > 1 || pattern_->height > 1;
  const bool same_size = !organised || (cloud.height == pattern_->height && cloud.width == pattern_->width);
  if (!same_size) {
    return fmt::format("the clouds have {} x {} points now, before {} x {}", cloud.height, cloud.width,
                       pattern_->height, pattern_->width);
  }
  if (cloud.fields != pattern_->fields || cloud.point_step != pattern_->point_step)
    return "the clouds have other fields now";
  if (turn_ && period && std::abs(period->seconds() / turn_->seconds() - 1) > kOtherTurn) {
    return fmt::format("the clouds come every {:.0f} ms now, before every {:.0f} ms", 1e3 * period->seconds(),
                       1e3 * turn_->seconds());
  }
  return "";
}

}  // namespace mapless
