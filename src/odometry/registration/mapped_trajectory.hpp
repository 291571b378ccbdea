#pragma once

#include <cstdint>
#include <deque>
#include <vector>

#include "odometry/map/plane_map.hpp"
#include "odometry/registration/scan_registration.hpp"
#include <mapless/lidar/lidar_scan.hpp>

namespace mapless::inline v1 {

/// The part of a scan that the odometry uses.
struct UsableScan {
  std::vector<ScanPoint> points;  ///< for the map
  TimeBins bins;                  ///< of the keypoints, for registration
  std::vector<ScanPoint> edges;   ///< select_edges(); none once the odometry has started
  Time start;
  std::size_t interval = 0;  ///< number of the knot at its start
};

/// The points of a scan that the map has accepted.
struct InsertedScan {
  struct Point {
    Eigen::Vector3d p_0;
    std::uint32_t return_index;  ///< in LidarScan::returns
    unsigned grids;              ///< bits, as PlaneMap::insert returns them
  };
  Time start;
  std::vector<Point> points;
};

/// The end of the scan, or its last return if that is later.
[[nodiscard]] Time end_of(const LidarScan& scan);

/// The prior of the first knot: at the origin by definition, with almost any velocity.
[[nodiscard]] WindowPrior origin_prior(const TrajectoryKnot& knot);

/// `knot` moved to time `t` with constant velocity.
[[nodiscard]] TrajectoryKnot predicted(const TrajectoryKnot& knot, Time t);

/// False if a registration is so far from the prediction that its association must be wrong. `interval_s`:
/// the time from the knot before, mostly the duration of a scan.
[[nodiscard]] bool is_plausible(const TrajectoryKnot& found, const TrajectoryKnot& prediction,
                                double interval_s);

/// A trajectory and the map built along it: a sliding window of open knots, all older ones final.
struct MappedTrajectory {
  explicit MappedTrajectory(double point_sigma_m) : map(point_sigma_m) {}

  std::vector<TrajectoryKnot> knots;
  std::size_t window_begin = 0;  ///< first knot that can still change
  WindowPrior prior;             ///< of the knots from there on; it may lack the last ones
  /// Whether accept() marginalises all but the last kWindowKnots knots. False until the motion of the first
  /// scan is known.
  bool marginalises = false;
  PlaneMap map;

  [[nodiscard]] std::vector<TrajectoryKnot> window() const {
    return {knots.begin() + static_cast<std::ptrdiff_t>(window_begin), knots.end()};
  }
  /// Duration of the last interval between knots; there must be two [s].
  [[nodiscard]] double last_interval_s() const;
  /// `settings` with the density of the motion so far. The last knot is a prediction and left out.
  [[nodiscard]] RegistrationSettings with_observed_density(RegistrationSettings settings) const;
  /// Appends a knot at `end`, which is end_of(scan), predicted with constant velocity; and one at the start
  /// of the scan if scans are missing before it.
  void append_knots(const LidarScan& scan, Time end);
  /// Takes over the knots of a registration of window(), and its posterior as the next prior.
  void accept(const Registration& registration);
  /// Estimates the last knot with the motion prior alone. Returns its covariance, 0 if there is no solution.
  Matrix12d extrapolate_with_prior(const RegistrationSettings& settings);
  /// Restarts the window at this knot: its pose stays, its velocity becomes unknown. Earlier knots are final.
  void restart_window_at(std::size_t interval);

  void insert(const UsableScan& scan, double map_radius_m);
  /// As LidarOdometry::remove_dynamic_points.
  void remove_dynamic_points(const LidarScan& scan, const std::vector<std::uint16_t>& object);
  void clear_map();

 private:
  void forget_edge(const Eigen::Vector3d& centre_0, double map_radius_m);

  Eigen::Vector3d map_cleared_at_0_ = Eigen::Vector3d::Zero();
  std::deque<InsertedScan> inserted_;  // the last ones
};

}  // namespace mapless
