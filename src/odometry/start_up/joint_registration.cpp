#include "odometry/start_up/joint_registration.hpp"

#include <algorithm>
#include <iterator>

#include <tbb/parallel_for.h>

#include "odometry/map/map_of_scans.hpp"
#include "odometry/map/points_in_world.hpp"
#include "odometry/registration/degeneracy.hpp"
#include "odometry/solver/secant_steps.hpp"

namespace mapless::inline v1 {
namespace {

// Most Gauss-Newton steps at full resolution. Chosen: twice those of a single scan (max_iterations), because
// the maps move with the scans.
constexpr int kMaxSteps = 30;
// RegistrationSettings::small_step: 3 mm and 0.3 mrad. Derived: a step moves a scan to where the others are,
// and these move as well, so that several steps hardly smaller than the first follow. Measured: with 5 the
// tunnel of TEST(StartUp, TheStepsOfAPersonAreNotEvenedOut) ends after two steps.
constexpr double kSmallJointStep = 3;
// The maps move with the scans, so that a step may lose inliers; along a weakly constrained direction it may
// diverge. The iteration ends at a step with fewer soft inliers than this part of the most so far; if the
// step was lengthened, it goes on from where these were, with steps as they are. Measured: without the limit
// one motorway start of 50 went from 27 to 10 m/s (docs/notebook/odometry.md, "How it starts").
constexpr double kMinInlierRatioOfBest = 0.99;
// From rest: cubes and gates begin 8 times as large and are halved down to their own size, with at most 15
// steps each. Derived: a hand swings a sensor so that points at 20 m move by 8 m between the first of eight
// scans and the last, and the cubes are 0.5 to 2 m. Measured on 33 flying starts: with 8, one errs by more
// than 0.10 m, with 4 six, with 2 all; with fewer steps 17 (docs/notebook/odometry.md, "How it starts").
constexpr double kScaleFromRest = 8;
constexpr int kMaxCoarseSteps = 15;

// The points of every scan. Ranges are those of cubes `scale` times as large.
std::vector<std::vector<MapPoint>> all_in_world(const std::vector<UsableScan>& scans,
                                                const std::vector<TrajectoryKnot>& knots, double scale) {
  std::vector<std::vector<MapPoint>> out;
  out.reserve(scans.size());
  for (const UsableScan& scan : scans) {
    out.push_back(points_in_world(scan.points, scan.start, knots[scan.interval], knots[scan.interval + 1]));
    for (MapPoint& point : out.back()) point.range_m /= scale;
  }
  return out;
}

void add_scan(std::size_t interval, std::vector<BinSums>& sums, const RegistrationSettings& settings,
              Registration& registration, WindowSystem& system) {
  const SE3& T_v0 = registration.knots[interval + 1].T_v0;
  registration.degeneracy = find_degeneracy(sums, T_v0, settings.min_constraint_ratio);
  project_out_unconstrained(registration.degeneracy, T_v0, sums);
  registration.inliers = 0;
  registration.soft_inliers = 0;
  for (const BinSums& bin : sums) {
    registration.inliers += bin.inliers;
    registration.soft_inliers += bin.soft_inliers;
  }
  // Every pair of scans enters twice, points of the first on planes of the second and the reverse, so each
  // would count half. But the derivative is taken for one scan alone: it leaves out that the points of the
  // others lie on planes of this one, which tell of its motion as much. Twice one half is the whole.
  add_points(sums, interval, kInformationRatio, system);
}

// The residuals of all scans, each against the map of the others; `scale` as above.
std::vector<std::vector<BinSums>> sums_of_all(const std::vector<UsableScan>& scans,
                                              const std::vector<TrajectoryKnot>& knots,
                                              const RegistrationSettings& settings, double scale,
                                              MapOfScans& map) {
  PointWeights weights = settings.weights;
  weights.gate_m *= scale;
  map.assign(all_in_world(scans, knots, scale));
  std::vector<std::vector<BinSums>> sums(scans.size());
  tbb::parallel_for(std::size_t{0}, scans.size(), [&](std::size_t s) {
    const KnotInterval interval(knots[scans[s].interval], knots[scans[s].interval + 1]);
    std::vector<CachedPlane> planes;
    sums[s] = sum_residuals(scans[s].bins, interval, map.without(s), weights, planes);
  });
  return sums;
}

// One step, lengthened by `steps`. Returns the soft inliers before it; none if there is no solution.
std::optional<double> joint_gauss_newton_step(const WindowPrior& prior, const std::vector<UsableScan>& scans,
                                              const RegistrationSettings& settings, double scale,
                                              MapOfScans& map, SecantSteps& steps,
                                              Registration& registration) {
  std::vector<TrajectoryKnot>& knots = registration.knots;
  WindowSystem system(knots.size());
  add_window_prior(prior, knots, 0, system);
  for (std::size_t k = 0; k + 1 < knots.size(); ++k) add_motion_terms(knots, k, settings, system);
  auto sums = sums_of_all(scans, knots, settings, scale, map);
  double soft_inliers = 0;
  for (std::size_t s = 0; s < scans.size(); ++s) {
    add_scan(scans[s].interval, sums[s], settings, registration, system);
    soft_inliers += registration.soft_inliers;
  }
  const auto solution = solve(system);
  if (!solution) return std::nullopt;
  const std::vector<Vector12d> step = steps.extrapolated(solution->step);
  for (std::size_t k = 0; k < knots.size(); ++k) knots[k] = perturbed(knots[k], step[k]);
  registration.last_information = solution->information.back();
  registration.posterior = marginal_of_last(kWindowKnots, knots, system, *solution);
  registration.converged = has_converged(step, settings.small_step);
  ++registration.iterations;
  return soft_inliers;
}

}  // namespace

std::optional<Registration> register_jointly(std::vector<TrajectoryKnot> knots, const WindowPrior& prior,
                                             const std::vector<UsableScan>& scans,
                                             RegistrationSettings settings) {
  settings.small_step = kSmallJointStep;
  MapOfScans map(settings.point_sigma_m);
  SecantSteps steps;
  Registration out;
  out.knots = std::move(knots);
  Registration best;
  double most_inliers = 0;
  while (out.iterations < kMaxSteps && !out.converged) {
    const std::vector<TrajectoryKnot> before = out.knots;
    const bool went_far = steps.has_extrapolated();
    const auto soft_inliers = joint_gauss_newton_step(prior, scans, settings, 1, map, steps, out);
    if (!soft_inliers) return std::nullopt;
    if (*soft_inliers < kMinInlierRatioOfBest * most_inliers) {
      if (!went_far) return best;
      best.iterations = out.iterations;
      out = best;
      steps = {};
    } else if (*soft_inliers > most_inliers) {
      most_inliers = *soft_inliers;
      best = out;
      best.knots = before;
      std::copy(before.end() - std::ssize(best.posterior.mean), before.end(), best.posterior.mean.begin());
    }
  }
  return out;
}

std::optional<Registration> register_from_rest(std::vector<TrajectoryKnot> knots, const WindowPrior& prior,
                                               const std::vector<UsableScan>& scans,
                                               const RegistrationSettings& settings) {
  Registration out;
  out.knots = std::move(knots);
  for (TrajectoryKnot& knot : out.knots) knot = {knot.time, prior.mean.front().T_v0, Vector6d::Zero()};
  for (double scale = kScaleFromRest; scale > 1; scale /= 2) {
    // Enlarged, the coarsest grid would hold little but the ground.
    MapOfScans map(scale * settings.point_sigma_m, scale, PlaneMap::kGrids - 1);
    RegistrationSettings level = settings;
    level.small_step = scale;
    out.converged = false;
    for (int i = 0; i < kMaxCoarseSteps && !out.converged; ++i) {
      SecantSteps plain;  // new for every step: none is lengthened
      if (!joint_gauss_newton_step(prior, scans, level, scale, map, plain, out)) return std::nullopt;
    }
  }
  return register_jointly(out.knots, prior, scans, settings);
}

double soft_inliers_of(const std::vector<TrajectoryKnot>& knots, const std::vector<UsableScan>& scans,
                       const RegistrationSettings& settings) {
  double out = 0;
  MapOfScans map(settings.point_sigma_m);
  for (const auto& sums : sums_of_all(scans, knots, settings, 1, map)) {
    for (const BinSums& bin : sums) out += bin.soft_inliers;
  }
  return out;
}

}  // namespace mapless
