#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <mapless/io/trajectory_source.hpp>
#include <mapless/odometry/lidar_odometry.hpp>

namespace mapless::app {

/// How the sensor moves: a trajectory given beforehand, or one estimated from the scans as they come.
class MotionSource {
 public:
  /// Lidar odometry where nothing is asked for and the recording brings no trajectory. Throws InputError
  /// where odometry cannot be (scan `first` is motion-compensated), and what open_trajectory throws.
  MotionSource(const Dataset& dataset, const TrajectoryRequest& request, std::size_t first);

  /// Lidar odometry whatever the recording brings. Throws InputError for a compensated recording when its
  /// first scan is added.
  [[nodiscard]] static MotionSource odometry();

  [[nodiscard]] bool estimated() const { return odometry_.has_value(); }
  /// Covers every scan that `add` or `flush` has returned.
  [[nodiscard]] const Trajectory& trajectory() const;
  [[nodiscard]] const TrajectorySource& source() const { return source_; }

  /// The scans whose motion is known now, in order. Odometry keeps the first until it has the second.
  std::vector<std::shared_ptr<const LidarScan>> add(std::shared_ptr<const LidarScan> scan);
  /// The scans still kept.
  std::vector<std::shared_ptr<const LidarScan>> flush();

  /// What odometry could not do: a line for people, empty where all is well.
  [[nodiscard]] std::string trouble() const;

 private:
  MotionSource() = default;
  void use_odometry();

  TrajectorySource source_;
  std::optional<LidarOdometry> odometry_;
  std::vector<std::shared_ptr<const LidarScan>> waiting_;
  std::size_t added_ = 0, by_prior_ = 0, restarts_ = 0, degenerate_ = 0, first_by_prior_ = 0;
};

}  // namespace mapless::app
