#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <vector>

#include <mapless/lidar/lidar_scan.hpp>
#include <mapless/trajectory/trajectory.hpp>

namespace mapless::inline v1 {

/// Start and end of a scan.
struct ScanInterval {
  Time start;
  Time end;
};

/// Which of two trajectories of one recording is right: under the right one, static points keep their place
/// in the world.
struct TrajectoryComparison {
  /// Largest difference between the motions of a point near the sensor from one scan to a later one, as the
  /// two trajectories have it.
  double difference_m = 0;
  /// Points of the compared scans whose displacements under the two trajectories differ.
  std::size_t points = 0;
  /// Medians, over these points, of the displacement from one scan to the other, perpendicular to the surface
  /// and at most kMaxDisplacement_m. Zero without points.
  double displacement_a_m = 0;
  double displacement_b_m = 0;

  /// The trajectories agree wherever they were compared: it does not matter which is taken.
  [[nodiscard]] bool same() const;
  /// There are enough points to decide which is right.
  [[nodiscard]] bool measured() const;
};

/// Largest distance [m] at which two points are taken to lie on the same surface.
inline constexpr double kMaxDisplacement_m = 1;

/// Reads scan k. Null: it cannot be read.
using ScanReader = std::function<std::shared_ptr<const LidarScan>(std::size_t)>;

/// Compares trajectories a and b of a recording by at most six of its scans: from each third of the recording
/// the first pair of scans up to 0.8 s apart between which the trajectories differ by 2 m, else the pair with
/// the largest difference. A scan that cannot be read is left out. Only points in a plane with
/// their neighbours count: perpendicular to it, their displacement does not depend on where the rays of the
/// other scan met it. Points of moving objects are a minority, which does not decide a median. Both
/// trajectories must cover all scans.
[[nodiscard]] TrajectoryComparison compare_trajectories(const Trajectory& a, const Trajectory& b,
                                                        const std::vector<ScanInterval>& scans,
                                                        const ScanReader& read);

/// Displacements of static points from one scan to another under one trajectory.
struct StaticDisplacement {
  double median_m = 0;  ///< perpendicular to the surface, at most kMaxDisplacement_m; 0 without points
  std::size_t points = 0;

  [[nodiscard]] bool measured() const;
};

/// Measures them in pairs of scans between which the sensor moves, chosen as compare_trajectories does.
/// Points that keep their place relative to the sensor do not count: they decide nothing, or move along with
/// it.
[[nodiscard]] StaticDisplacement measure_static_displacement(const Trajectory& trajectory,
                                                             const std::vector<ScanInterval>& scans,
                                                             const ScanReader& read);

}  // namespace mapless
