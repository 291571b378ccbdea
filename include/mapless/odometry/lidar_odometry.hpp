#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include <Eigen/Core>

#include <mapless/lidar/lidar_scan.hpp>
#include <mapless/odometry/parameters.hpp>
#include <mapless/trajectory/trajectory.hpp>

namespace mapless::inline v1 {

using Vector12d = Eigen::Matrix<double, 12, 1>;
using Matrix12d = Eigen::Matrix<double, 12, 12>;

/// How the end of a scan was found.
enum class ScanOutcome {
  first,       ///< nothing to compare with yet: the sensor is taken to stand still until the next scan comes
  registered,  ///< from its points
  few_points,  ///< too few usable returns: carried by the prior
  repeated,    ///< the same returns as the scan before, delivered again: carried by the prior
  lost,        ///< too few points found their place in the map, or no solution: carried by the prior
  restarted,   ///< lost several times in a row: the map begins anew with this scan
};

/// How well the matched points hold each direction of translation: the mean square of (plane normal .
/// direction), rotation allowed for, between 0 (not at all) and about 1.
struct Degeneracy {
  Eigen::Vector3d share = Eigen::Vector3d::Zero();             ///< increasing
  Eigen::Matrix3d directions_v = Eigen::Matrix3d::Identity();  ///< columns, sensor frame at the scan's end
  int held_by_prior = 0;  ///< how many of them, from the first: their points are not believed
};

/// What one scan told about the motion.
struct OdometryUpdate {
  /// Knots that this scan set or changed, by time; the last is at the scan's end. Those of the two scans
  /// before are among them: how fast the sensor was at the end of a scan is told by the scans after it.
  std::vector<TrajectoryKnot> knots;
  /// Of the last knot: left perturbation of T_v0 (translation, rotation), then varpi.
  Matrix12d covariance = Matrix12d::Zero();
  ScanOutcome outcome = ScanOutcome::first;
  int iterations = 0;
  double matched_share = 0;  ///< of the keypoints
  Degeneracy degeneracy;
  bool converged = false;
  /// The motion of the first scans is decided with this one, but another one explains them about as well: the
  /// speed may be wrong, and with it all that follows.
  bool ambiguous = false;
};

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

  /// Takes what the map has of moving things out of it again, as a detector finds them: `object` has one
  /// element per return of `scan`, not 0 for a return of something that moves (Detection::object). Nothing
  /// happens for a scan that is not among the last ten, or whose returns are not so many.
  void leave_out(const LidarScan& scan, const std::vector<std::uint16_t>& object);

  /// False until the motion during the first scans is decided (see process). The knots are then the best
  /// known so far.
  [[nodiscard]] bool started() const;
  /// All knots so far, by time.
  [[nodiscard]] const std::vector<TrajectoryKnot>& knots() const;
  /// The trajectory so far. Lives as long as this object and grows with it; not to be asked while a scan is
  /// processed. Empty domain before the first scan.
  [[nodiscard]] const Trajectory& trajectory() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace mapless
