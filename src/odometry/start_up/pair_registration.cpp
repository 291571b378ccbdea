#include "odometry/start_up/pair_registration.hpp"

#include <algorithm>
#include <cmath>

#include <tbb/parallel_for.h>

#include "odometry/map/points_in_world.hpp"
#include "odometry/start_up/joint_registration.hpp"

namespace mapless::inline v1 {
namespace {

// Points of the first scan in the maps of the coarse registrations. Chosen: half of max_scan_points, because
// each step of the 37 coarse registrations builds a map.
constexpr std::size_t kCoarsePoints = 8000;
// Without the coarsest grid of PlaneMap, in which the ground alone constrains the motion.
constexpr std::size_t kGrids = PlaneMap::kGrids - 1;
// The initial velocities are tried with cubes and gates 4 times as large, at most 4 steps, then 2 steps in
// their own size; the best 9 different ones are refined. Chosen: the initial speeds are 1 m per scan apart
// (10 Hz), the enlarged gate is 2 m. Measured: with a fraction of the points, 8 of 40 motorway starts fail
// for 4; more steps did not help (docs/notebook/odometry.md, "How it starts").
constexpr double kCoarsestScale = 4;
constexpr int kCoarseSteps = 4;
constexpr int kFineSteps = 2;
constexpr std::size_t kMaxRefined = 9;
// Prior of the velocity about an initial velocity. Derived: the initial speeds are 10 m/s apart, the turn
// rates 1.7 rad/s, so that half of that is well within one and two standard deviations.
constexpr double kSpeedSigma_mps = 8;
constexpr double kTurnRateSigma_radps = 1;
// The same about a velocity that later scans have determined; they may be half a second apart.
constexpr double kNearSpeedSigma_mps = 0.5;
constexpr double kNearTurnRateSigma_radps = 0.5;
// Most steps of a motion of the edges, first with a part of the first scan's points, then with all. Chosen:
// from a right motion four to six steps suffice; a wrong one need not become accurate.
constexpr int kEdgeSteps = 8;
// The same along a direction in which the speed is imposed: far below the steps between these speeds.
constexpr double kImposedSpeedSigma_mps = 0.02;
// RegistrationSettings::small_step: 5 mm and 0.5 mrad. Points change their planes from step to step, so that
// in a forest the steps stay at 1 to 5 mm for 25 steps. Measured: docs/notebook/odometry.md, "Cost of the
// start".
constexpr double kSmallPairStep = 5;
// Fewest soft inliers of a motion. Measured without the limit on flying starts: one better, two worse
// (docs/notebook/odometry.md, "How it starts").
constexpr double kMinSoftInliers = 50;
// Two scans leave the speed along a direction open if the constraint ratio times the inliers is below this:
// so many points facing the direction constrain it. Such a speed is sampled in steps of 3 m/s, up to 45 m/s
// (160 km/h) either way. Derived: 3 m/s is 0.3 m per scan at 10 Hz, at most 0.15 m from the truth, which the
// next scan corrects in cubes of 0.5 m.
constexpr double kFewConstrainingPoints = 20;
constexpr double kSpeedStep_mps = 3;
constexpr int kSpeedSteps = 15;

// Rest, and speeds up to 40 m/s and turn rates up to 3.4 rad/s (195 deg/s) along every axis of the sensor: no
// axis is assumed to point up or ahead.
std::vector<Vector6d> initial_velocities() {
  std::vector<Vector6d> out = {Vector6d::Zero()};
  const auto add = [&](double amount, Eigen::Index first) {
    for (Eigen::Index axis = first; axis < first + 3; ++axis)
      for (const double sign : {1., -1.}) out.push_back(sign * amount * Vector6d::Unit(axis));
  };
  for (const double speed_mps : {10., 20., 30., 40.}) add(speed_mps, 0);
  for (const double turn_rate_radps : {1.7, 3.4}) add(turn_rate_radps, 3);
  return out;
}

// The same with what other sensors measure in its place, no two alike.
std::vector<Vector6d> initial_velocities(const KnownMotion& known) {
  std::vector<Vector6d> out;
  for (const Vector6d& varpi : initial_velocities()) {
    const Vector6d applied = known.applied_to(varpi);
    if (std::none_of(out.begin(), out.end(), [&](const Vector6d& one) { return one.isApprox(applied); }))
      out.push_back(applied);
  }
  return out;
}

// Speeds along `direction` to try, `varpi` being the best motion.
std::vector<double> speeds_along(const Eigen::Vector3d& direction, const Vector6d& varpi,
                                 const KnownMotion& known) {
  if (known.velocity) return {direction.dot(*known.velocity)};
  if (known.speed) {
    const Eigen::Vector3d v = varpi.head<3>();
    const double across_squared = (v - direction.dot(v) * direction).squaredNorm();
    const double along = std::sqrt(std::max(0.0, *known.speed * *known.speed - across_squared));
    return {along, -along};
  }
  std::vector<double> out;
  for (int step = -kSpeedSteps; step <= kSpeedSteps; ++step) out.push_back(kSpeedStep_mps * step);
  return out;
}

Registration constant_velocity(std::vector<TrajectoryKnot> knots, const Vector6d& varpi) {
  for (TrajectoryKnot& knot : knots) {
    knot.T_v0 = SE3::exp((knot.time - knots.front().time).seconds() * varpi) * knots.front().T_v0;
    knot.varpi = varpi;
  }
  Registration out;
  out.knots = std::move(knots);
  return out;
}

bool has_more_inliers(const Registration& a, const Registration& b) {
  return a.soft_inliers > b.soft_inliers;
}

bool is_duplicate(const std::vector<Registration>& all, const Registration& registration) {
  return std::any_of(all.begin(), all.end(), [&](const Registration& one) {
    return are_alike(one.knots.back(), registration.knots.back());
  });
}

// Inserts in the order of soft inliers.
void add_unless_duplicate(std::vector<Registration>& all, const Registration& registration) {
  if (registration.soft_inliers < kMinSoftInliers || is_duplicate(all, registration)) return;
  const auto place = std::find_if(
      all.begin(), all.end(), [&](const Registration& one) { return has_more_inliers(registration, one); });
  all.insert(place, registration);
}

std::vector<ScanPoint> evenly_sampled(const std::vector<ScanPoint>& points, std::size_t most) {
  const std::size_t number = std::min(points.size(), most);
  const std::vector<std::uint32_t> passes = pass_order(points.size());
  std::vector<std::uint32_t> chosen;
  for (std::size_t i = 0; i < number; ++i) chosen.push_back(passes[i * points.size() / number]);
  std::sort(chosen.begin(), chosen.end());
  std::vector<ScanPoint> out;
  for (const std::uint32_t i : chosen) out.push_back(points[i]);
  return out;
}

// The results of `function` for all `starts`, in their order, without the empty ones.
template <class Start, class Function>
std::vector<Registration> transform_parallel(const std::vector<Start>& starts, const Function& function) {
  std::vector<std::optional<Registration>> found(starts.size());
  tbb::parallel_for(std::size_t{0}, starts.size(), [&](std::size_t i) { found[i] = function(starts[i]); });
  std::vector<Registration> out;
  for (auto& registration : found) {
    if (registration) out.push_back(std::move(*registration));
  }
  return out;
}

}  // namespace

Vector6d KnownMotion::applied_to(Vector6d varpi) const {
  const double guess = varpi.head<3>().norm();
  if (speed && guess > 0) varpi.head<3>() *= *speed / guess;
  if (velocity) varpi.head<3>() = *velocity;
  if (angular_velocity) varpi.tail<3>() = *angular_velocity;
  return varpi;
}

bool are_alike(const TrajectoryKnot& a, const TrajectoryKnot& b) { return are_alike(a.varpi, b.varpi); }

PairOfScans::PairOfScans(std::vector<TrajectoryKnot> knots, WindowPrior prior, const UsableScan& first,
                         const UsableScan& second, std::size_t first_knot,
                         const RegistrationSettings& settings)
    : knots_(std::move(knots)),
      prior_(std::move(prior)),
      first_(first),
      second_(second),
      first_interval_(first.interval - first_knot),
      settings_(settings),
      coarse_points_(evenly_sampled(first.points, kCoarsePoints)) {}

WindowPrior PairOfScans::velocity_prior(const Vector6d& varpi, double speed_sigma,
                                        double turn_rate_sigma) const {
  WindowPrior out = prior_;
  out.mean.front().varpi = varpi;
  Vector6d sigma;
  sigma << Eigen::Vector3d::Constant(speed_sigma), Eigen::Vector3d::Constant(turn_rate_sigma);
  out.diagonal.front().bottomRightCorner<6, 6>() = sigma.cwiseInverse().cwiseAbs2().asDiagonal();
  return out;
}

KnownMotion PairOfScans::known_motion() const {
  KnownMotion out;
  if (settings_.measurements == nullptr) return out;
  const Time first = knots_.front().time, end = knots_.back().time;
  const auto mean = [&](MeasuredMotion quantity) -> std::optional<Eigen::Vector3d> {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    int count = 0;
    for (const MotionMeasurement& one : *settings_.measurements) {
      if (one.quantity != quantity || one.time < first || one.time >= end) continue;
      sum += one.value;
      ++count;
    }
    if (count == 0) return std::nullopt;
    return sum / count;
  };
  if (const auto v = mean(MeasuredMotion::velocity)) out.velocity = -*v;
  if (const auto v = mean(MeasuredMotion::angular_velocity)) out.angular_velocity = -*v;
  if (const auto v = mean(MeasuredMotion::speed)) out.speed = v->x();
  return out;
}

// Gauss-Newton steps with cubes and gates `scale` times as large.
bool PairOfScans::iterate(double scale, int steps, bool coarse, const WindowPrior& prior,
                          Registration& registration) const {
  RegistrationSettings level = settings_;
  level.weights.gate_m *= scale;
  level.small_step = kSmallPairStep;
  registration.converged = false;
  PlaneMap map(scale * settings_.point_sigma_m, scale, kGrids);
  for (int i = 0; i < steps && !registration.converged; ++i) {
    std::vector<CachedPlane> planes;
    map.clear();
    fill(registration, scale, coarse, map);
    if (!gauss_newton_step(prior, second_.bins, map, level, planes, registration)) return false;
  }
  return true;
}

void PairOfScans::fill(const Registration& registration, double scale, bool coarse, PlaneMap& map) const {
  const auto& points = coarse ? coarse_points_ : first_.points;
  auto points_0 = points_in_world(points, first_.start, registration.knots[first_interval_],
                                  registration.knots[first_interval_ + 1]);
  for (MapPoint& point : points_0) point.range_m /= scale;
  (void)map.insert(points_0);
}

bool PairOfScans::refine(Registration& registration) const {
  const WindowPrior prior =
      velocity_prior(registration.knots.back().varpi, kSpeedSigma_mps, kTurnRateSigma_radps);
  registration.iterations = 0;
  for (double scale = kCoarsestScale / 2; scale > 1; scale /= 2) {
    if (!iterate(scale, kCoarseSteps, false, prior, registration)) return false;
  }
  return iterate(1, settings_.max_iterations, false, prior, registration);
}

std::optional<Registration> PairOfScans::register_coarsely(const Vector6d& varpi) const {
  const WindowPrior prior = velocity_prior(varpi, kSpeedSigma_mps, kTurnRateSigma_radps);
  Registration out = constant_velocity(knots_, varpi);
  if (!iterate(kCoarsestScale, kCoarseSteps, true, prior, out)) return std::nullopt;
  if (!iterate(1, kFineSteps, true, prior, out)) return std::nullopt;
  return out;
}

std::vector<Registration> PairOfScans::coarse_registrations() const {
  std::vector<Registration> found = transform_parallel(
      initial_velocities(known_motion()), [&](const Vector6d& varpi) { return register_coarsely(varpi); });
  std::stable_sort(found.begin(), found.end(), has_more_inliers);
  std::vector<Registration> distinct;
  for (Registration& registration : found) {
    if (distinct.size() < kMaxRefined && !is_duplicate(distinct, registration))
      distinct.push_back(std::move(registration));
  }
  return distinct;
}

// Imposes the speed along `direction`. The posterior is the one without, so that later scans can correct the
// speed.
std::optional<Registration> PairOfScans::register_at_speed(const Vector6d& varpi,
                                                           const Eigen::Vector3d& direction) const {
  WindowPrior prior = velocity_prior(varpi, kSpeedSigma_mps, kTurnRateSigma_radps);
  Registration free = constant_velocity(knots_, varpi);
  if (!iterate(1, 1, true, prior, free)) return std::nullopt;
  prior.diagonal.front().block<3, 3>(6, 6) +=
      direction * direction.transpose() / (kImposedSpeedSigma_mps * kImposedSpeedSigma_mps);
  Registration out = constant_velocity(knots_, varpi);
  if (!iterate(1, kCoarseSteps, true, prior, out)) return std::nullopt;
  out.last_information = free.last_information;
  out.posterior = prior_of(out.knots.back(), free.last_information);
  return out;
}

// Adds motions that differ from the best one along its weakly constrained directions.
void PairOfScans::add_along_weak_directions(std::vector<Registration>& all) const {
  const Registration best = all.front();
  const Degeneracy& degeneracy = best.degeneracy;
  for (Eigen::Index i = 0; i < 3 && degeneracy.constraint_ratio[i] * best.inliers < kFewConstrainingPoints;
       ++i) {
    const Eigen::Vector3d direction = degeneracy.directions_v.col(i);
    const double speed_along = direction.dot(best.knots.back().varpi.head<3>());
    std::vector<Vector6d> velocities;
    for (const double speed : speeds_along(direction, best.knots.back().varpi, known_motion())) {
      velocities.push_back(best.knots.back().varpi);
      velocities.back().head<3>() += (speed - speed_along) * direction;
    }
    const auto along = transform_parallel(
        velocities, [&](const Vector6d& varpi) { return register_at_speed(varpi, direction); });
    for (const Registration& registration : along) add_unless_duplicate(all, registration);
  }
}

WindowPrior PairOfScans::prior_of_edges(const EdgeMotion& motion) const {
  WindowPrior prior = prior_;
  prior.mean.front().varpi = known_motion().applied_to(motion.varpi);
  prior.diagonal.front().bottomRightCorner<6, 6>() = motion.information;
  return prior;
}

// The motions of the edges, registered to a part of the points. Of motions that came to be alike only the one
// whose edges agree best is kept.
std::vector<PairOfScans::EdgeCandidate> PairOfScans::edge_candidates(
    const std::vector<EdgeMotion>& motions) const {
  std::vector<EdgeCandidate> found(motions.size());
  tbb::parallel_for(std::size_t{0}, motions.size(), [&](std::size_t i) {
    EdgeCandidate& one = found[i];
    one.prior = prior_of_edges(motions[i]);
    one.registration = constant_velocity(knots_, one.prior.mean.front().varpi);
    one.solved = iterate(1, kEdgeSteps, true, one.prior, one.registration);
  });
  std::vector<EdgeCandidate> out;
  double most = 0;
  for (const EdgeCandidate& one : found) most = std::max(most, one.registration.soft_inliers);
  for (EdgeCandidate& one : found) {
    if (one.registration.soft_inliers < kMinInliersOfMost * most) continue;
    const bool duplicate = std::any_of(out.begin(), out.end(), [&](const EdgeCandidate& other) {
      return are_alike(one.registration.knots.back(), other.registration.knots.back());
    });
    if (one.solved && !duplicate) out.push_back(std::move(one));
  }
  return out;
}

std::vector<Registration> PairOfScans::register_by_edges(const std::vector<EdgeMotion>& motions) const {
  const std::vector<Registration> found =
      transform_parallel(edge_candidates(motions), [&](EdgeCandidate one) -> std::optional<Registration> {
        one.registration.iterations = 0;
        if (!iterate(1, kEdgeSteps, false, one.prior, one.registration)) return std::nullopt;
        return one.registration;
      });
  std::vector<Registration> out;
  for (const Registration& registration : found) add_unless_duplicate(out, registration);
  keep_if_any(out, [&](const Registration& one) { return !is_contradicted(one.knots, settings_); });
  return out;
}

std::vector<Registration> PairOfScans::register_by_planes() const {
  const auto refined =
      transform_parallel(coarse_registrations(), [&](Registration candidate) -> std::optional<Registration> {
        if (!refine(candidate)) return std::nullopt;
        return candidate;
      });
  std::vector<Registration> out;
  for (const Registration& registration : refined) add_unless_duplicate(out, registration);
  if (!out.empty()) add_along_weak_directions(out);
  keep_if_any(out, [&](const Registration& one) { return !is_contradicted(one.knots, settings_); });
  return out;
}

PairOfScans::Candidates PairOfScans::candidates() const {
  const std::vector<EdgeMotion> motions = edge_motions(first_, second_);
  Candidates out;
  if (!motions.empty()) out.all = register_by_edges(motions);
  out.by_edges = !out.all.empty();
  if (out.by_edges && motions.front().agreement >= kSureAgreement) return out;
  for (const Registration& registration : register_by_planes()) add_unless_duplicate(out.all, registration);
  return out;
}

std::optional<Registration> PairOfScans::register_near(const Vector6d& varpi) const {
  const WindowPrior prior = velocity_prior(varpi, kNearSpeedSigma_mps, kNearTurnRateSigma_radps);
  Registration out = constant_velocity(knots_, varpi);
  if (!iterate(1, settings_.max_iterations, false, prior, out)) return std::nullopt;
  return out;
}

}  // namespace mapless
