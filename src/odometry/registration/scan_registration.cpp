#include "odometry/registration/scan_registration.hpp"

#include <algorithm>

#include "odometry/registration/degeneracy.hpp"

namespace mapless::inline v1 {
namespace {

// A step is small if it moves every pose by less than this. Chosen: a twentieth of the range noise (0.02 m),
// and the angle that moves a point at 10 m by as much.
constexpr double kSmallTranslation_m = 1e-3;
constexpr double kSmallRotation_rad = 1e-4;
// The Cauchy scale begins 8 / 2 = 4 times as wide and is halved before every step: with a poor prediction all
// points are far from their planes (graduated non-convexity; method.md section 6, "Map").
constexpr double kFirstWidening = 8;
// The first half of a scan that lasts longer is registered first, alone: at its end the prediction errs by a
// quarter of what it errs at the end of the scan. Measured at 5 Hz: of 63 recordings a tunnel, where a hand
// turns the sensor back at 7 rad/s^2, and a random place lose their motion without; the mean drift is .6
// instead of 2.1 % (docs/notebook/odometry.md, "Five turns a second").
constexpr double kLongScan_s = 0.15;
// For an unexpected motion: the gate begins this much wider, 2 m at first, and the density of the prior is
// larger. Chosen: 30 times the density allows sqrt(30) = 5.5 times the change of velocity.
constexpr double kWideGate = 4;
constexpr double kWideDensity = 30;

bool is_small(const Vector12d& step, double scale) {
  return step.head<3>().norm() < scale * kSmallTranslation_m &&
         step.segment<3>(3).norm() < scale * kSmallRotation_rad;
}

}  // namespace

bool has_converged(const std::vector<Vector12d>& steps, double scale) {
  return std::all_of(steps.begin(), steps.end(), [&](const Vector12d& s) { return is_small(s, scale); });
}

void add_motion_terms(const std::vector<TrajectoryKnot>& knots, std::size_t k,
                      const RegistrationSettings& settings, WindowSystem& system) {
  add_motion_prior(knots, k, settings.density, system);
  if (settings.measurements != nullptr) add_measurements(*settings.measurements, knots, k, system);
}

bool is_contradicted(const std::vector<TrajectoryKnot>& knots, const RegistrationSettings& settings) {
  return settings.measurements != nullptr && contradict(knots, *settings.measurements);
}

bool gauss_newton_step(const WindowPrior& prior, const TimeBins& bins, const PlaneSource& map,
                       const RegistrationSettings& settings, std::vector<CachedPlane>& planes,
                       Registration& registration) {
  std::vector<TrajectoryKnot>& knots = registration.knots;
  const std::size_t last = knots.size() - 1;
  const SE3& T_v0 = knots[last].T_v0;
  // Points: association and point-to-plane residuals by time bin, without unconstrained directions (method.md
  // 6).
  auto sums = sum_residuals(bins, KnotInterval(knots[last - 1], knots[last]), map, settings.weights, planes);
  const Degeneracy degeneracy = find_degeneracy(sums, T_v0, settings.min_constraint_ratio);
  project_out_unconstrained(degeneracy, T_v0, sums);

  // Normal equations: the prior of the window, the white-noise-on-acceleration prior between the knots that
  // it does not cover (Anderson and Barfoot, IROS 2015; method.md 3), and the points.
  WindowSystem system(knots.size());
  add_window_prior(prior, knots, 0, system);
  for (std::size_t k = prior.mean.size() - 1; k < last; ++k) add_motion_terms(knots, k, settings, system);
  add_points(sums, last - 1, kInformationRatio, system);
  const auto solution = solve(system);
  if (!solution) return false;

  // The step, and the posterior of the open knots with all older ones marginalised.
  for (std::size_t k = 0; k <= last; ++k) knots[k] = perturbed(knots[k], solution->step[k]);
  registration.last_information = solution->information.back();
  registration.posterior = marginal_of_last(kWindowKnots, knots, system, *solution);
  registration.degeneracy = degeneracy;
  registration.inliers = 0;
  registration.soft_inliers = 0;
  for (const BinSums& bin : sums) {
    registration.inliers += bin.inliers;
    registration.soft_inliers += bin.soft_inliers;
  }
  registration.converged = has_converged(solution->step, settings.small_step);
  ++registration.iterations;
  return true;
}

namespace {

// Gauss-Newton with a loss and a gate that begin `loss` and `gate` times as wide and are halved every step,
// down to their own size.
std::optional<Registration> register_annealed(std::vector<TrajectoryKnot> knots, const WindowPrior& prior,
                                              const TimeBins& bins, const PlaneSource& map,
                                              const RegistrationSettings& settings, double loss,
                                              double gate) {
  Registration out;
  out.knots = std::move(knots);
  RegistrationSettings level = settings;
  std::vector<CachedPlane> planes;
  while (!(out.converged && loss <= 1 && gate <= 1) && out.iterations < settings.max_iterations) {
    loss = std::max(1.0, loss / 2);
    level.weights.robust_sigmas = loss * settings.weights.robust_sigmas;
    level.weights.gate_m = gate * settings.weights.gate_m;
    if (!gauss_newton_step(prior, bins, map, level, planes, out)) return std::nullopt;
    gate = std::max(1.0, gate / 2);
  }
  return out;
}

}  // namespace

std::optional<Registration> register_scan(std::vector<TrajectoryKnot> knots, const WindowPrior& prior,
                                          const TimeBins& bins, const PlaneSource& map,
                                          const RegistrationSettings& settings) {
  const Time start = knots[knots.size() - 2].time;
  const Duration scan = knots.back().time - start;
  if (scan.seconds() > kLongScan_s && !bins.points().empty()) {
    const TimeBins half = bins.before(start + Duration::from_nanoseconds(scan.nanoseconds() / 2));
    auto found = register_annealed(knots, prior, half, map, settings, kFirstWidening, 1);
    if (found && found->inliers > 0) knots = std::move(found->knots);
  }
  return register_annealed(std::move(knots), prior, bins, map, settings, kFirstWidening, 1);
}

std::optional<Registration> register_with_wide_gate(std::vector<TrajectoryKnot> knots,
                                                    const WindowPrior& prior, const TimeBins& bins,
                                                    const PlaneSource& map,
                                                    const RegistrationSettings& settings) {
  RegistrationSettings loose = settings;
  loose.density.translation *= kWideDensity;
  loose.density.rotation *= kWideDensity;
  const auto found =
      register_annealed(std::move(knots), prior, bins, map, loose, kWideGate * kFirstWidening, kWideGate);
  if (!found) return std::nullopt;
  return register_annealed(found->knots, prior, bins, map, settings, 1, 1);
}

}  // namespace mapless
