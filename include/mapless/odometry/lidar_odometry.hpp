#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include <mapless/lidar/lidar_scan.hpp>
#include <mapless/odometry/odometry_update.hpp>
#include <mapless/odometry/parameters.hpp>
#include <mapless/trajectory/trajectory.hpp>

namespace mapless::inline v1 {

/// Continuous-time odometry from the lidar alone: a Gaussian process with white noise on acceleration, one
/// knot at the end of every scan, point-to-plane registration to a rolling voxel map with every point at its
/// own instant (Anderson and Barfoot, IROS 2015; Burnett et al. 2022; method.md sections 3 and 6). Three
/// knots stay open, older ones are marginalised.
///
/// The world frame 0 is the sensor frame at the start of the first scan.
class LidarOdometry {
 public:
  explicit LidarOdometry(const OdometryParameters& parameters = {});
  ~LidarOdometry();
  LidarOdometry(LidarOdometry&&) noexcept;
  LidarOdometry& operator=(LidarOdometry&&) noexcept;

  /// Extends the trajectory to the end of `scan`. The first five to ten usable scans, until started(), may
  /// change all knots before them: together they tell how fast the sensor was from the first on. Throws
  /// InputError for a scan that starts before the last one or ends within it, or was compensated by somebody
  /// else; the odometry is then as before the call.
  OdometryUpdate process(const std::shared_ptr<const LidarScan>& scan);

  /// Removes the points of dynamic objects from the map, once a detector has found them. `object` has one
  /// element per return of `scan` (Detection::object): 0 is static, anything else dynamic. Nothing happens if
  /// `scan` is not among the last ten, or if `object` has another length than its returns.
  void remove_dynamic_points(const LidarScan& scan, const std::vector<std::uint16_t>& object);

  /// False until the motion during the first scans is decided (see process). The knots are then the best
  /// known so far.
  [[nodiscard]] bool started() const;
  /// All knots so far, by time.
  [[nodiscard]] const std::vector<TrajectoryKnot>& knots() const;
  /// The trajectory so far. It lives as long as this object and grows with every scan, so that no other
  /// thread may read it while process() runs. Its domain is empty before the first scan.
  [[nodiscard]] const Trajectory& trajectory() const;
  /// The trajectory as it is now, for another thread to keep: immutable, with no tie to this object. Costs
  /// the copy of at most 260 knots (50 kB), and 16 bytes for every further 256. Call it in the thread that
  /// calls process(). Its domain is empty before the first scan.
  [[nodiscard]] std::shared_ptr<const Trajectory> trajectory_snapshot() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace mapless
