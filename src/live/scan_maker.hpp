#pragma once

#include <cstddef>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "live/cloud_queue.hpp"
#include <mapless/lidar/scan_builder.hpp>
#include <mapless/lidar/self_check.hpp>

namespace mapless::inline v1 {

/// A cloud and the scan made of it.
struct MadeScan {
  Arrival arrival;
  std::shared_ptr<const LidarScan> scan;
  std::vector<std::string> doubts;  // ScanWatch::take_lines
};

/// Makes scans of clouds. The first clouds are kept until the sensor is known: eight where it is recovered,
/// three where it is named (for the duration of a turn). Not thread-safe.
class ScanMaker {
 public:
  /// Called with the reason why a cloud cannot be used.
  using Refuse = std::function<void(const std::string&)>;

  /// `clock_offset`: LiveParameters::clock_offset_s.
  ScanMaker(std::optional<LidarModel> sensor, std::string topic, Duration clock_offset);

  /// Takes the next cloud and returns the scans that can be made now, in order. `period`: of the clouds.
  [[nodiscard]] std::vector<MadeScan> add(Arrival arrival, std::optional<Duration> period,
                                          const Refuse& refuse);
  /// The clouds to come are of another sensor, or of another setting of it.
  void forget_sensor();

  /// Why a cloud cannot be of the sensor of the clouds before; empty where it can.
  [[nodiscard]] std::string difference(const PointCloud2View& cloud, std::optional<Duration> period) const;
  /// Where times and rings come from, and how the sensor was recovered; empty until the sensor is known.
  [[nodiscard]] const std::vector<std::string>& notes() const { return notes_; }
  [[nodiscard]] std::string sensor() const { return builder_ ? builder_->model()->name : ""; }

 private:
  [[nodiscard]] bool prepare(std::optional<Duration> period, const Refuse& refuse);
  void set_turn(Duration period);
  [[nodiscard]] std::optional<MadeScan> make(Arrival arrival, const Refuse& refuse);

  std::optional<LidarModel> sensor_;
  std::string topic_;
  Duration clock_offset_;
  std::optional<ScanBuilder> builder_;
  std::optional<Duration> turn_;
  ScanWatch watch_;
  std::size_t watched_ = 0;
  std::deque<Arrival> kept_;                // until the sensor is known
  std::optional<PointCloud2View> pattern_;  // layout of the clouds; its data are not used
  std::vector<std::string> notes_;
};

}  // namespace mapless
