#pragma once

#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "live/health.hpp"
#include "live/transform_buffer.hpp"
#include <mapless/core/time.hpp>
#include <mapless/live/live_options.hpp>
#include <mapless/trajectory/trajectory.hpp>

namespace mapless::inline v1 {

/// Velocities that an inertial sensor or the wheels measure, until the cloud comes during which they were
/// measured. Holds the last ten seconds at most. Not thread-safe.
class MeasurementQueue {
 public:
  explicit MeasurementQueue(const LiveParameters& parameters) : parameters_(parameters) {}

  struct Measured {
    std::string frame;
    Time time;
    std::optional<Eigen::Vector3d> linear;  ///< of the frame, in its axes [m/s]; none: of an inertial sensor
    Eigen::Vector3d angular;                ///< [rad/s]
  };
  /// A measurement whose stamp is farther than max_gap_s from that of the newest cloud is on another clock,
  /// and not used.
  void add(Measured measured, std::optional<Time> newest_cloud, Time now, Health& health);

  /// What was measured until `end`, as of the lidar whose clouds are in `lidar_frame`; it is removed. Of
  /// wheels the speed is used alone: their directions need the mounting to a degree. Reports an input that is
  /// switched on and has nothing in [begin, end], and one whose frame has no place on the lidar.
  [[nodiscard]] std::vector<MotionMeasurement> take(const std::string& lidar_frame, Time begin, Time end,
                                                    const TransformBuffer& transforms, Time now,
                                                    Health& health);
  void clear() { waiting_.clear(); }
  [[nodiscard]] std::size_t used() const { return used_; }

 private:
  void report_missing(bool imu, bool wheels, Time now, Health& health) const;

  LiveParameters parameters_;
  std::deque<Measured> waiting_;  // in the order of their arrival
  std::size_t used_ = 0;
};

}  // namespace mapless
