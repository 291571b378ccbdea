#pragma once

#include <optional>
#include <vector>

#include "odometry/registration/time_bins.hpp"
#include "odometry/solver/prior_terms.hpp"
#include "odometry/solver/window_prior.hpp"

namespace mapless::inline v1 {

/// Of the information of its points, what a scan really brings: points of one surface share the errors of its
/// plane, and those of the poses that it was seen from. With this share the velocity errs by what its
/// covariance says over simulated drives of every scene (docs/odometry.md).
inline constexpr double kPointShare = 0.3;

/// Knots that scans to come still correct, the newest among them. How fast a sensor was at the end of a scan
/// the scans after it tell: the first two nearly all of it, a third little more (docs/odometry.md).
inline constexpr std::size_t kKnotsKept = 3;

struct RegistrationSettings {
  AccelerationDensity density;
  PointWeights weights;
  double sigma_m;  ///< noise expected of a point
  double min_constraint_ratio;
  int max_iterations;
};

/// A window of knots after registration of the scan in its last interval.
struct Registration {
  std::vector<TrajectoryKnot> knots;
  Matrix12d last_information;  ///< of the last knot, the others marginalised
  WindowPrior known;           ///< of the last kKnotsKept knots
  int iterations = 0;
  int matched = 0;
  double agreement = 0;  ///< of the matched points, summed
  Degeneracy degeneracy;
  bool converged = false;
};

/// Whether a step of all knots is so small that another one will not be felt, by planes `scale` times as
/// large as the map's.
[[nodiscard]] bool are_small(const std::vector<Vector12d>& steps, double scale = 1);

/// One Gauss-Newton step. `planes`: of the points, as the step before left them; empty where the map is
/// another one. False where there is no solution; `registration` is then as before.
[[nodiscard]] bool improve(const WindowPrior& prior, const TimeBins& bins, const PlaneMap& map,
                           const RegistrationSettings& settings, std::vector<PlaneNear>& planes,
                           Registration& registration);

/// Steps until they are small, or `max_iterations`. None where there is no solution.
[[nodiscard]] std::optional<Registration> register_scan(std::vector<TrajectoryKnot> knots,
                                                        const WindowPrior& prior, const TimeBins& bins,
                                                        const PlaneMap& map,
                                                        const RegistrationSettings& settings);

/// The same for a motion that changed more than the prior thinks likely: gates and loss begin wider, and the
/// prior holds less.
[[nodiscard]] std::optional<Registration> register_widely(std::vector<TrajectoryKnot> knots,
                                                          const WindowPrior& prior, const TimeBins& bins,
                                                          const PlaneMap& map,
                                                          const RegistrationSettings& settings);

}  // namespace mapless
