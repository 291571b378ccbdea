#include "odometry/start_up/joint_registration.hpp"

#include <algorithm>
#include <iterator>

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include "odometry/map/points_in_world.hpp"
#include "odometry/registration/degeneracy.hpp"

namespace mapless::inline v1 {
namespace {

constexpr int kSteps = 30;
// The maps move with the scans, so that a step need not lead to more agreement, and where points hardly hold
// a direction one can lead far off. From one good step to the next the agreement changes by less than this.
constexpr double kAboutAsMany = 0.99;
// From rest, whose planes begin so many times as large, with so many steps of each size: a hand swings a
// sensor by 8 m at 20 m between the first of eight scans and the last.
constexpr double kScaleFromRest = 8;
constexpr int kCoarseSteps = 15;
// Every pair of scans is seen from both sides, by points of the one on planes of the other and by points of
// the other on planes of the one: what they tell counts half.
constexpr double kOfBothSides = 0.5;

using WorldPoints = std::vector<std::vector<MapPoint>>;  // of each scan

WorldPoints all_in_world(const std::vector<UsableScan>& scans, const std::vector<TrajectoryKnot>& knots) {
  WorldPoints out;
  for (std::size_t s = 0; s < scans.size(); ++s) {
    const UsableScan& scan = scans[s];
    out.push_back(points_in_world(scan.points, scan.start, knots[scan.interval], knots[scan.interval + 1],
                                  kLinesApart * static_cast<unsigned>(s)));
  }
  return out;
}

// Gives `use` the map of the others of each scan, with cubes `scale` times as large. Each begins as that of
// the scans before its own, which is made once; no more of them are kept than threads can use.
template <typename Use>
void for_each_map_of_others(const WorldPoints& points_0, double sigma_m, double scale, const Use& use) {
  PlaneMap before(scale * sigma_m, scale, scale > 1 ? PlaneMap::kGrids - 1 : PlaneMap::kGrids);
  const auto at_once = static_cast<std::size_t>(tbb::this_task_arena::max_concurrency());
  for (std::size_t first = 0; first < points_0.size(); first += at_once) {
    const std::size_t end = std::min(first + at_once, points_0.size());
    std::vector<PlaneMap> maps;
    for (std::size_t s = first; s < end; ++s) {
      maps.push_back(before);
      (void)before.insert(points_0[s]);
    }
    tbb::parallel_for(first, end, [&](std::size_t s) {
      PlaneMap& others = maps[s - first];
      for (std::size_t later = s + 1; later < points_0.size(); ++later) (void)others.insert(points_0[later]);
      use(s, others);
    });
  }
}

void add_scan(std::size_t interval, std::vector<BinSums>& sums, const RegistrationSettings& settings,
              Registration& registration, WindowSystem& system) {
  const SE3& T_v0 = registration.knots[interval + 1].T_v0;
  registration.degeneracy = find_degeneracy(sums, T_v0, settings.min_constraint_ratio);
  leave_to_prior(registration.degeneracy, T_v0, sums);
  registration.matched = 0;
  registration.agreement = 0;
  for (const BinSums& bin : sums) {
    registration.matched += bin.matched;
    registration.agreement += bin.agreement;
  }
  add_points(sums, interval, kOfBothSides * kPointShare, system);
}

// The residuals of all scans, each to the map of the others; `scale` as above.
std::vector<std::vector<BinSums>> sums_of_all(const std::vector<UsableScan>& scans,
                                              const std::vector<TrajectoryKnot>& knots,
                                              const RegistrationSettings& settings, double scale) {
  PointWeights weights = settings.weights;
  weights.gate_m *= scale;
  WorldPoints points_0 = all_in_world(scans, knots);
  for (std::vector<MapPoint>& points : points_0) {
    for (MapPoint& point : points) point.range_m /= scale;
  }
  std::vector<std::vector<BinSums>> sums(scans.size());
  for_each_map_of_others(points_0, settings.sigma_m, scale, [&](std::size_t s, const PlaneMap& others) {
    const KnotInterval interval(knots[scans[s].interval], knots[scans[s].interval + 1]);
    std::vector<PlaneNear> planes;
    sums[s] = sum_residuals(scans[s].bins, interval, others, weights, planes);
  });
  return sums;
}

// The agreement before the step, or none where there is no solution.
std::optional<double> improve_jointly(const WindowPrior& prior, const std::vector<UsableScan>& scans,
                                      const RegistrationSettings& settings, double scale,
                                      Registration& registration) {
  std::vector<TrajectoryKnot>& knots = registration.knots;
  WindowSystem system(knots.size());
  add_window_prior(prior, knots, 0, system);
  for (std::size_t k = 0; k + 1 < knots.size(); ++k) add_motion_prior(knots, k, settings.density, system);
  auto sums = sums_of_all(scans, knots, settings, scale);
  double agreement = 0;
  for (std::size_t s = 0; s < scans.size(); ++s) {
    add_scan(scans[s].interval, sums[s], settings, registration, system);
    agreement += registration.agreement;
  }
  const auto solution = solve(system);
  if (!solution) return std::nullopt;
  for (std::size_t k = 0; k < knots.size(); ++k) knots[k] = perturbed(knots[k], solution->step[k]);
  registration.last_information = solution->information.back();
  registration.known = prior_of_last(kKnotsKept, knots, system, *solution);
  registration.converged = are_small(solution->step, scale);
  ++registration.iterations;
  return agreement;
}

}  // namespace

std::optional<Registration> register_jointly(std::vector<TrajectoryKnot> knots, const WindowPrior& prior,
                                             const std::vector<UsableScan>& scans,
                                             const RegistrationSettings& settings) {
  Registration out;
  out.knots = std::move(knots);
  Registration best;
  double most = 0;
  while (out.iterations < kSteps && !out.converged) {
    const std::vector<TrajectoryKnot> before = out.knots;
    const auto agreement = improve_jointly(prior, scans, settings, 1, out);
    if (!agreement) return std::nullopt;
    if (*agreement < kAboutAsMany * most) return best;
    if (*agreement <= most) continue;
    most = *agreement;
    best = out;
    best.knots = before;
    std::copy(before.end() - std::ssize(best.known.mean), before.end(), best.known.mean.begin());
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
    out.converged = false;
    for (int i = 0; i < kCoarseSteps && !out.converged; ++i) {
      if (!improve_jointly(prior, scans, settings, scale, out)) return std::nullopt;
    }
  }
  return register_jointly(out.knots, prior, scans, settings);
}

double agreement_of(const std::vector<TrajectoryKnot>& knots, const std::vector<UsableScan>& scans,
                    const RegistrationSettings& settings) {
  double out = 0;
  for (const auto& sums : sums_of_all(scans, knots, settings, 1)) {
    for (const BinSums& bin : sums) out += bin.agreement;
  }
  return out;
}

}  // namespace mapless
