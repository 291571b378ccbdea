#pragma once

#include <optional>
#include <vector>

#include "odometry/registration/mapped_trajectory.hpp"

namespace mapless::inline v1 {

/// Registers the second scan of a recording to the first, without any knowledge of the velocity. After every
/// step the first scan is compensated again with the motion found.
class PairOfScans {
 public:
  /// `knots` begin with knot number `first_knot`, in which UsableScan::interval counts. The second scan is in
  /// the last interval.
  PairOfScans(std::vector<TrajectoryKnot> knots, WindowPrior prior, const UsableScan& first,
              const UsableScan& second, std::size_t first_knot, const RegistrationSettings& settings);

  /// All motions that the two scans admit, for later scans to decide between: the one with most inliers
  /// first, no two alike (are_alike), none with fewer than 50 soft inliers.
  [[nodiscard]] std::vector<Registration> register_all() const;
  /// The motion near a velocity that is known to 0.5 m/s and 0.5 rad/s.
  [[nodiscard]] std::optional<Registration> register_near(const Vector6d& varpi) const;

 private:
  [[nodiscard]] WindowPrior velocity_prior(const Vector6d& varpi, double speed_sigma,
                                           double turn_rate_sigma) const;
  bool iterate(double scale, int steps, bool coarse, const WindowPrior& prior,
               Registration& registration) const;
  bool refine(Registration& registration) const;
  [[nodiscard]] PlaneMap map_of(const Registration& registration, double scale, bool coarse) const;
  [[nodiscard]] std::optional<Registration> register_coarsely(const Vector6d& varpi) const;
  [[nodiscard]] std::optional<Registration> register_at_speed(const Vector6d& varpi,
                                                              const Eigen::Vector3d& direction) const;
  [[nodiscard]] std::vector<Registration> coarse_registrations() const;
  void add_along_weak_directions(std::vector<Registration>& all) const;

  std::vector<TrajectoryKnot> knots_;
  WindowPrior prior_;
  const UsableScan& first_;
  const UsableScan& second_;
  std::size_t first_interval_;
  const RegistrationSettings& settings_;
  std::vector<ScanPoint> coarse_points_;  // of the first scan
};

/// Whether the velocities at the end of two motions differ by less than 0.5 m/s and 0.1 rad/s: then they are
/// the same motion, found twice.
[[nodiscard]] bool are_alike(const TrajectoryKnot& a, const TrajectoryKnot& b);

}  // namespace mapless
