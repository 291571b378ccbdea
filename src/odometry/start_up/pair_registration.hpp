#pragma once

#include <optional>
#include <vector>

#include "odometry/registration/mapped_trajectory.hpp"

namespace mapless::inline v1 {

/// Two scans whose sensor may have been moving, or turning, from the very first on. The second is registered
/// to the first, which is compensated anew with the motion found after every step.
class PairOfScans {
 public:
  /// `knots` from number `first_knot` on, which is what UsableScan::interval counts from; the second scan is
  /// in the last interval.
  PairOfScans(std::vector<TrajectoryKnot> knots, WindowPrior prior, const UsableScan& first,
              const UsableScan& second, std::size_t first_knot, const RegistrationSettings& settings);

  /// Every motion that may have been, which is for the scans after them to decide: best first, no two alike,
  /// none that few points agree with.
  [[nodiscard]] std::vector<Registration> register_all() const;
  /// With a velocity that is known to some 0.5 m/s and 0.5 rad/s.
  [[nodiscard]] std::optional<Registration> register_near(const Vector6d& varpi) const;

 private:
  [[nodiscard]] WindowPrior expected(const Vector6d& varpi, double speed_sigma, double turn_rate_sigma) const;
  bool improve_at(double scale, int steps, bool rough, const WindowPrior& prior,
                  Registration& registration) const;
  bool refine(Registration& registration) const;
  [[nodiscard]] PlaneMap map_of(const Registration& registration, double scale, bool rough) const;
  [[nodiscard]] std::optional<Registration> roughly(const Vector6d& varpi) const;
  [[nodiscard]] std::optional<Registration> held(const Vector6d& varpi,
                                                 const Eigen::Vector3d& direction) const;
  [[nodiscard]] std::vector<Registration> all_roughly() const;
  void add_along_weak(std::vector<Registration>& all) const;

  std::vector<TrajectoryKnot> knots_;
  WindowPrior prior_;
  const UsableScan& first_;
  const UsableScan& second_;
  std::size_t first_interval_;
  const RegistrationSettings& settings_;
  std::vector<ScanPoint> rough_;
};

/// Whether both end with about the same velocity, [m/s] and [rad/s]: the same motion, found twice.
[[nodiscard]] bool are_alike(const TrajectoryKnot& a, const TrajectoryKnot& b);

}  // namespace mapless
