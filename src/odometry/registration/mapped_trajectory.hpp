#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <vector>

#include "odometry/map/seen_through.hpp"
#include "odometry/registration/scan_registration.hpp"
#include <mapless/lidar/lidar_scan.hpp>

namespace mapless::inline v1 {

/// Numbers of the lines (PlaneGrid::insert) of two scans: odd, so that they fall apart.
inline constexpr unsigned kLinesApart = 29;

/// What odometry uses of a scan.
struct UsableScan {
  std::vector<ScanPoint> points;
  TimeBins bins;                            ///< of its keypoints
  std::shared_ptr<const SeenThrough> seen;  ///< null once the odometry has started
  Time start;
  std::size_t interval = 0;  ///< the knot at its start
};

/// What the map took of a scan.
struct InsertedScan {
  struct Point {
    Eigen::Vector3d p_0;
    std::uint32_t return_index;
    unsigned taken;  ///< by which grids
  };
  Time start;
  std::vector<Point> points;
};

/// The end of the scan, or its last return where that is later.
[[nodiscard]] Time end_of(const LidarScan& scan);

/// Of a scan whose sensor is at the origin by definition, and may move as it likes.
[[nodiscard]] WindowPrior prior_of_first(const TrajectoryKnot& knot);

/// Where a knot is at another time if it keeps its velocity.
[[nodiscard]] TrajectoryKnot predicted(const TrajectoryKnot& knot, Time t);

/// False for a registration that leaves the prediction so far that it must have found something else.
[[nodiscard]] bool is_plausible(const TrajectoryKnot& found, const TrajectoryKnot& prediction);

/// A trajectory as far as it is known, and the map that its scans made.
struct MappedTrajectory {
  explicit MappedTrajectory(double sigma_m) : map(sigma_m) {}

  std::vector<TrajectoryKnot> knots;
  std::size_t window_begin = 0;  ///< first knot that can still change
  WindowPrior prior;             ///< of the knots from there on, the last one not always among them
  /// All knots but the last kKnotsKept; not before the motion of the first scan is known.
  bool marginalises = false;
  PlaneMap map;

  [[nodiscard]] std::vector<TrajectoryKnot> window() const {
    return {knots.begin() + static_cast<std::ptrdiff_t>(window_begin), knots.end()};
  }
  /// With the density of the motion so far, the last knot not yet known.
  [[nodiscard]] RegistrationSettings with_own_density(RegistrationSettings settings) const;
  /// A knot at `end`, that of the scan (end_of), and one at its start where scans are missing before it.
  void append_knots(const LidarScan& scan, Time end);
  void accept(const Registration& registration);
  /// The last knot as the prior has it; its covariance, or 0 where that cannot be told.
  Matrix12d carry_by_prior(const RegistrationSettings& settings);
  /// Forgets what is known of the motion but for the place of this knot; those before it stay as they are.
  void begin_anew_at(std::size_t interval);

  void insert(const UsableScan& scan, double map_radius_m);
  void remove_dynamic_points(const LidarScan& scan, const std::vector<std::uint16_t>& object);
  void clear_map();

 private:
  void forget_edge(const Eigen::Vector3d& centre_0, double map_radius_m);

  Eigen::Vector3d map_cleared_at_0_ = Eigen::Vector3d::Zero();
  unsigned inserted_scans_ = 0;
  std::deque<InsertedScan> inserted_;  // the last ones
};

}  // namespace mapless
