#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include <mapless/lidar/lidar_scan.hpp>
#include <mapless/odometry/odometry_update.hpp>
#include <mapless/odometry/parameters.hpp>
#include <mapless/trajectory/trajectory.hpp>

namespace mapless::inline v1 {

/// Continuous-time odometry from the lidar alone. Scans with a time per return go in; the trajectory of the
/// sensor comes out: a Gaussian process with white noise on acceleration, with one knot (pose and velocity)
/// at the end of every scan (Anderson and Barfoot, IROS 2015). Each point is registered point-to-plane to a
/// rolling map, at its own instant (Burnett et al., RA-L 2022). The last three knots are open, older ones are
/// marginalised. Formulas: docs/method.md, sections 3 and 6. The map and the window cannot be touched from
/// outside, but for remove_dynamic_points().
///
/// World frame 0 is the sensor frame at the start of the first scan. Same scans, same trajectory, for any
/// number of threads.
class LidarOdometry {
 public:
  /// Throws ParameterError naming the parameter, its value and its bounds if one is out of bounds or not a
  /// number.
  explicit LidarOdometry(const OdometryParameters& parameters = {});
  ~LidarOdometry();
  LidarOdometry(LidarOdometry&&) noexcept;
  LidarOdometry& operator=(LidarOdometry&&) noexcept;

  /// Extends the trajectory to the end of `scan`. Until started(), a scan may correct all knots before it,
  /// then the last three. A scan that cannot be registered is not an error: see OdometryUpdate::outcome.
  /// Throws InputError for a scan that is null, that starts before the last one or ends within it, that has
  /// no duration, or that is already motion-compensated; the odometry is then as before the call.
  OdometryUpdate process(const std::shared_ptr<const LidarScan>& scan);

  /// What another sensor measures of the motion: a factor in the estimate. Give it before process() of the
  /// scan during which it was measured; measurements of the first scans also decide between the motions that
  /// these admit. One before the knots that can still change has no effect. A scan whose motion contradicts
  /// the measurements during it by five standard deviations is reported as lost. Throws InputError for a
  /// value that is not finite, a negative speed, and a sigma that is not greater than 0.
  void add_measurement(const MotionMeasurement& measured);

  /// Removes the points of dynamic objects from the map, once a detector has found them. `object` has one
  /// element per return of `scan` (Detection::object): 0 is static, anything else dynamic. Nothing happens if
  /// `scan` is not among the last ten, or if `object` has another length than its returns.
  void remove_dynamic_points(const LidarScan& scan, const std::vector<std::uint16_t>& object);

  /// Drops knots whose motion nobody will ask for, on a drive without end: knots() and trajectory() then
  /// begin at `t` at the latest. Estimates do not change. Knots go 256 at a time, and the last 21 stay;
  /// during a start-up none goes. Snapshots made before keep their knots.
  void forget_before(Time t);

  /// Whether the motion of the first scans is decided, after five to ten usable scans. Until then the knots
  /// are those of the best motion so far. False again after a loss, from a scan with ScanOutcome::restarted
  /// on.
  [[nodiscard]] bool started() const;
  /// All knots so far, without those dropped, by increasing time. The reference is valid until the next call
  /// of process().
  [[nodiscard]] const std::vector<TrajectoryKnot>& knots() const;
  /// The trajectory over knots(). Its domain is empty before the first scan. The reference is valid until the
  /// next call of process().
  [[nodiscard]] const Trajectory& trajectory() const;
  /// The same trajectory, for another thread to keep: immutable, and without any tie to this object. Every
  /// call of process() makes a new one, by a copy of at most 260 knots (50 kB) and 16 bytes for every further
  /// 256 knots.
  [[nodiscard]] std::shared_ptr<const Trajectory> trajectory_snapshot() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace mapless
