#include "odometry/registration/scan_registration.hpp"

#include <algorithm>

#include "odometry/registration/degeneracy.hpp"

namespace mapless::inline v1 {
namespace {

// A step is small when it moves the last pose less than this.
constexpr double kSmallTranslation = 1e-3;
constexpr double kSmallRotation = 1e-4;
// The loss begins as much wider and is halved every step: a bad prediction puts all points far off.
constexpr double kFirstWidening = 8;
// For a motion out of the ordinary: the gate begins as much wider, the density of the prior is larger.
constexpr double kWideGate = 4;
constexpr double kWideDensity = 30;

bool is_small(const Vector12d& step, double scale) {
  return step.head<3>().norm() < scale * kSmallTranslation &&
         step.segment<3>(3).norm() < scale * kSmallRotation;
}

}  // namespace

bool are_small(const std::vector<Vector12d>& steps, double scale) {
  return std::all_of(steps.begin(), steps.end(), [&](const Vector12d& s) { return is_small(s, scale); });
}

bool improve(const WindowPrior& prior, const TimeBins& bins, const PlaneMap& map,
             const RegistrationSettings& settings, std::vector<PlaneNear>& planes,
             Registration& registration) {
  std::vector<TrajectoryKnot>& knots = registration.knots;
  const std::size_t last = knots.size() - 1;
  const SE3& T_v0 = knots[last].T_v0;
  auto sums = sum_residuals(bins, KnotInterval(knots[last - 1], knots[last]), map, settings.weights, planes);
  const Degeneracy degeneracy = find_degeneracy(sums, T_v0, settings.min_constraint_ratio);
  leave_to_prior(degeneracy, T_v0, sums);

  WindowSystem system(knots.size());
  add_window_prior(prior, knots, 0, system);
  // Between knots of the prior it has what is known of the motion.
  for (std::size_t k = prior.mean.size() - 1; k < last; ++k)
    add_motion_prior(knots, k, settings.density, system);
  add_points(sums, last - 1, kPointShare, system);
  const auto solution = solve(system);
  if (!solution) return false;

  for (std::size_t k = 0; k <= last; ++k) knots[k] = perturbed(knots[k], solution->step[k]);
  registration.last_information = solution->information.back();
  registration.known = prior_of_last(kKnotsKept, knots, system, *solution);
  registration.degeneracy = degeneracy;
  registration.matched = 0;
  registration.agreement = 0;
  for (const BinSums& bin : sums) {
    registration.matched += bin.matched;
    registration.agreement += bin.agreement;
  }
  registration.converged = are_small(solution->step);
  ++registration.iterations;
  return true;
}

namespace {

// Gate and loss begin `widening` times as wide and are halved, each down to its own.
std::optional<Registration> narrowing(std::vector<TrajectoryKnot> knots, const WindowPrior& prior,
                                      const TimeBins& bins, const PlaneMap& map,
                                      const RegistrationSettings& settings, double loss, double gate) {
  Registration out;
  out.knots = std::move(knots);
  RegistrationSettings level = settings;
  std::vector<PlaneNear> planes;
  while (!(out.converged && loss <= 1 && gate <= 1) && out.iterations < settings.max_iterations) {
    loss = std::max(1.0, loss / 2);
    level.weights.robust_sigmas = loss * settings.weights.robust_sigmas;
    level.weights.gate_m = gate * settings.weights.gate_m;
    if (!improve(prior, bins, map, level, planes, out)) return std::nullopt;
    gate = std::max(1.0, gate / 2);
  }
  return out;
}

}  // namespace

std::optional<Registration> register_scan(std::vector<TrajectoryKnot> knots, const WindowPrior& prior,
                                          const TimeBins& bins, const PlaneMap& map,
                                          const RegistrationSettings& settings) {
  return narrowing(std::move(knots), prior, bins, map, settings, kFirstWidening, 1);
}

std::optional<Registration> register_widely(std::vector<TrajectoryKnot> knots, const WindowPrior& prior,
                                            const TimeBins& bins, const PlaneMap& map,
                                            const RegistrationSettings& settings) {
  RegistrationSettings loose = settings;
  loose.density.translation *= kWideDensity;
  loose.density.rotation *= kWideDensity;
  const auto found =
      narrowing(std::move(knots), prior, bins, map, loose, kWideGate * kFirstWidening, kWideGate);
  if (!found) return std::nullopt;
  return narrowing(found->knots, prior, bins, map, settings, 1, 1);
}

}  // namespace mapless
