#pragma once

#include <optional>
#include <vector>

#include "odometry/registration/time_bins.hpp"
#include "odometry/solver/measurement_terms.hpp"
#include "odometry/solver/prior_terms.hpp"
#include "odometry/solver/window_prior.hpp"

namespace mapless::inline v1 {

// registration/ estimates the knots at the ends of a scan. The keypoints of the scan, the map and the prior
// of the window go in; the corrected knots, their posterior and the figures of the registration come out.
// Only MappedTrajectory changes a map or a trajectory; everything else here is a function of its arguments.

/// The part of their summed information that the points of a scan contribute. Their errors are correlated:
/// points of one surface share the error of its plane, and all points share those of the poses from which the
/// plane was observed. Measured: with 0.3 the error of the velocity matches its covariance (NEES .46 to 1.3)
/// over simulated drives of every scene (docs/notebook/odometry.md, "Is its covariance right?").
inline constexpr double kInformationRatio = 0.3;

/// Knots that the next scans still correct, the newest included. The velocity at the end of a scan shows in
/// the scans after it. Measured: two knots lower its error by 12 to 22 %, three by another 2 to 6 %, four by
/// another 1 % (docs/notebook/odometry.md, "Two later scans correct a knot").
inline constexpr std::size_t kWindowKnots = 3;

struct RegistrationSettings {
  AccelerationDensity density;
  PointWeights weights;
  double point_sigma_m;  ///< expected noise of a point
  double min_constraint_ratio;
  int max_iterations;
  const MotionMeasurements* measurements = nullptr;  ///< of other sensors; null: none
  double small_step = 1;                             ///< scale of has_converged()
};

/// Adds what the prior of the window does not cover between knots k and k + 1: the motion prior, and the
/// measurements of other sensors.
void add_motion_terms(const std::vector<TrajectoryKnot>& knots, std::size_t k,
                      const RegistrationSettings& settings, WindowSystem& system);

/// Whether the motion contradicts the measurements of other sensors (contradict()).
[[nodiscard]] bool is_contradicted(const std::vector<TrajectoryKnot>& knots,
                                   const RegistrationSettings& settings);

/// A window of knots after registration of the scan in its last interval.
struct Registration {
  std::vector<TrajectoryKnot> knots;
  Matrix12d last_information;  ///< of the last knot, the others marginalised
  WindowPrior posterior;       ///< of the last kWindowKnots knots: the prior of the next scan
  int iterations = 0;
  int inliers = 0;
  double soft_inliers = 0;  ///< sum of the inliers' robust weights
  Degeneracy degeneracy;
  bool converged = false;
};

/// Whether a step moves every knot by less than `scale` x 1 mm and 0.1 mrad.
[[nodiscard]] bool has_converged(const std::vector<Vector12d>& steps, double scale);

/// One Gauss-Newton step. `planes` caches the association of the step before; pass an empty vector if the map
/// is another one. Returns false if there is no solution; `registration` is then as before.
[[nodiscard]] bool gauss_newton_step(const WindowPrior& prior, const TimeBins& bins, const PlaneSource& map,
                                     const RegistrationSettings& settings, std::vector<CachedPlane>& planes,
                                     Registration& registration);

/// Iterates until convergence, at most `max_iterations` times. `knots` are the initial guess; their last
/// interval is that of the scan. If it lasts more than .15 s, the points of its first half are registered
/// first, in as many iterations of their own. None if there is no solution.
[[nodiscard]] std::optional<Registration> register_scan(std::vector<TrajectoryKnot> knots,
                                                        const WindowPrior& prior, const TimeBins& bins,
                                                        const PlaneSource& map,
                                                        const RegistrationSettings& settings);

/// The same for a motion that the prior finds unlikely: it begins with a wider gate, a wider loss and a
/// looser motion prior.
[[nodiscard]] std::optional<Registration> register_with_wide_gate(std::vector<TrajectoryKnot> knots,
                                                                  const WindowPrior& prior,
                                                                  const TimeBins& bins,
                                                                  const PlaneSource& map,
                                                                  const RegistrationSettings& settings);

}  // namespace mapless
