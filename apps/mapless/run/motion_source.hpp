#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <mapless/detection/detector.hpp>
#include <mapless/io/trajectory_file.hpp>
#include <mapless/odometry/lidar_odometry.hpp>

namespace mapless::app {

/// What odometry met in a run, counted in scans.
struct OdometryReport {
  std::size_t scans = 0;
  std::size_t extrapolated = 0;  ///< the motion is what the prior says: few points, lost or repeated
  std::size_t first_extrapolated = 0;
  std::size_t few_points = 0, repeated = 0, lost = 0;
  std::size_t restarts = 0;       ///< the map was begun anew; these count as lost, too
  std::size_t gaps = 0;           ///< scans are missing before this one
  std::size_t degenerate = 0;     ///< the points do not hold every direction
  std::size_t not_converged = 0;  ///< registered, but still moving at the last step, or much less matched
  bool ambiguous_start = false;   ///< another motion explains the first scans about as well
};

/// How the sensor moves: a trajectory given beforehand, or one estimated from the scans as they come.
class MotionSource {
 public:
  /// Lidar odometry where nothing is asked for and the recording brings no trajectory. Throws InputError
  /// where odometry cannot be (scan `first` is motion-compensated), and what open_trajectory throws.
  MotionSource(const Dataset& dataset, const TrajectoryRequest& request, std::size_t first,
               const OdometryParameters& parameters = {});

  /// Lidar odometry whatever the recording brings, from scan `first` on. Throws InputError where that is
  /// motion-compensated.
  [[nodiscard]] static MotionSource odometry(const Dataset& dataset, std::size_t first = 0,
                                             const OdometryParameters& parameters = {});

  [[nodiscard]] bool estimated() const { return odometry_.has_value(); }
  /// Covers every scan that `add` or `flush` has returned.
  [[nodiscard]] const Trajectory& trajectory() const;
  /// The same from `from` on, as it is now: whatever is added later does not change it.
  [[nodiscard]] std::shared_ptr<const Trajectory> known_from(Time from) const;
  [[nodiscard]] const TrajectorySource& source() const { return source_; }

  /// The scans whose motion is known now, in order. Odometry keeps the first five to ten until it has
  /// started.
  std::vector<std::shared_ptr<const LidarScan>> add(std::shared_ptr<const LidarScan> scan);
  /// The scans still kept.
  std::vector<std::shared_ptr<const LidarScan>> flush();

  /// What the detector found moving in a scan; odometry's map leaves it out.
  void leave_out(const Detection& detection);

  [[nodiscard]] const OdometryReport& report() const { return report_; }
  /// What odometry could not do: a line for people, empty where all is well.
  [[nodiscard]] std::string trouble() const;

 private:
  MotionSource() = default;
  void use_odometry(const OdometryParameters& parameters);
  void count(const LidarScan& scan, const OdometryUpdate& update);

  TrajectorySource source_;
  std::optional<LidarOdometry> odometry_;
  std::vector<std::shared_ptr<const LidarScan>> waiting_;
  OdometryReport report_;
  Time last_end_;
};

}  // namespace mapless::app
