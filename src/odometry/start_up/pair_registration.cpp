#include "odometry/start_up/pair_registration.hpp"

#include <algorithm>
#include <cmath>

#include <tbb/parallel_for.h>

#include "odometry/map/points_in_world.hpp"

namespace mapless::inline v1 {
namespace {

constexpr std::size_t kRoughPoints = 8000;  // of the first scan, for the first rough registrations
// Not the coarsest, where the ground alone decides.
constexpr std::size_t kGrids = 3;
constexpr int kRoughSteps = 4;
constexpr double kCoarsestScale = 4;  // times the map's cubes and the gate
constexpr std::size_t kRefined = 9;   // of the velocities tried
// Rest is left only for something clearly better.
constexpr double kSlow = 1;             // [m/s]
constexpr double kSlowTurn = 0.2;       // [rad/s]
constexpr double kClearlyBetter = 1.5;  // standard deviations of a count
// How far from a velocity that is tried another may be found, and from one that is about known.
constexpr double kSpeedSigma = 8;           // [m/s]
constexpr double kTurnRateSigma = 1;        // [rad/s]
constexpr double kNearSpeedSigma = 0.5;     // [m/s]
constexpr double kNearTurnRateSigma = 0.5;  // [rad/s]
constexpr double kHeldSigma = 0.02;         // [m/s]
// Velocities nearer to each other than this are one.
constexpr double kAlikeSpeed = 0.5;  // [m/s]
constexpr double kAlikeTurn = 0.1;   // [rad/s]
constexpr double kFewestAgreeing = 50;
// Where no more than so many of the matched points hold a direction, two scans do not tell the speed along it
// (share x matched: the mean square of (plane normal . direction), summed). It is tried in steps that the
// scans after them, each so much farther on, can find the truth from: 3 m/s are 0.3 m a scan at 10 Hz, and
// the cubes of the map are 0.5 m and more.
constexpr double kWeaklyHeld = 20;
constexpr double kSpeedStep = 3;  // [m/s]
constexpr int kSpeedSteps = 15;   // on either side

// In the sensor's frame, on all its axes alike: nothing tells which way is up, or ahead.
std::vector<Vector6d> velocities_to_try() {
  std::vector<Vector6d> out = {Vector6d::Zero()};
  const auto add = [&](double amount, Eigen::Index first) {
    for (Eigen::Index axis = first; axis < first + 3; ++axis)
      for (const double sign : {1., -1.}) out.push_back(sign * amount * Vector6d::Unit(axis));
  };
  for (const double speed : {10., 20., 30., 40.}) add(speed, 0);  // [m/s]
  for (const double turn : {1.7, 3.4}) add(turn, 3);              // [rad/s]
  return out;
}

Registration moving_with(std::vector<TrajectoryKnot> knots, const Vector6d& varpi) {
  for (TrajectoryKnot& knot : knots) {
    knot.T_v0 = SE3::exp((knot.time - knots.front().time).seconds() * varpi) * knots.front().T_v0;
    knot.varpi = varpi;
  }
  Registration out;
  out.knots = std::move(knots);
  return out;
}

bool is_nearly_at_rest(const Registration& registration) {
  const Vector6d& varpi = registration.knots.back().varpi;
  return varpi.head<3>().norm() < kSlow && varpi.tail<3>().norm() < kSlowTurn;
}

bool has_more_agreement(const Registration& a, const Registration& b) { return a.agreement > b.agreement; }

bool is_better(const Registration& a, const Registration& b) {
  const double margin = is_nearly_at_rest(b) ? kClearlyBetter * std::sqrt(b.agreement) : 0;
  return a.agreement > b.agreement + margin;
}

bool is_known(const std::vector<Registration>& all, const Registration& registration) {
  return std::any_of(all.begin(), all.end(), [&](const Registration& one) {
    return are_alike(one.knots.back(), registration.knots.back());
  });
}

// Keeps its place by how many points agree; rest before what is hardly better.
void add_unless_known(std::vector<Registration>& all, const Registration& registration) {
  if (registration.agreement < kFewestAgreeing || is_known(all, registration)) return;
  const auto place = std::find_if(all.begin(), all.end(),
                                  [&](const Registration& one) { return is_better(registration, one); });
  all.insert(place, registration);
}

std::vector<ScanPoint> every_so_often(const std::vector<ScanPoint>& points, std::size_t most) {
  const std::size_t number = std::min(points.size(), most);
  const std::vector<std::uint32_t> passes = in_passes(points.size());
  std::vector<std::uint32_t> chosen;
  for (std::size_t i = 0; i < number; ++i) chosen.push_back(passes[i * points.size() / number]);
  std::sort(chosen.begin(), chosen.end());
  std::vector<ScanPoint> out;
  for (const std::uint32_t i : chosen) out.push_back(points[i]);
  return out;
}

// What `function` makes of each, where it makes anything, in their order.
template <class Start, class Function>
std::vector<Registration> for_each(const std::vector<Start>& starts, const Function& function) {
  std::vector<std::optional<Registration>> found(starts.size());
  tbb::parallel_for(std::size_t{0}, starts.size(), [&](std::size_t i) { found[i] = function(starts[i]); });
  std::vector<Registration> out;
  for (auto& registration : found) {
    if (registration) out.push_back(std::move(*registration));
  }
  return out;
}

}  // namespace

bool are_alike(const TrajectoryKnot& a, const TrajectoryKnot& b) {
  const Vector6d difference = a.varpi - b.varpi;
  return difference.head<3>().norm() < kAlikeSpeed && difference.tail<3>().norm() < kAlikeTurn;
}

PairOfScans::PairOfScans(std::vector<TrajectoryKnot> knots, WindowPrior prior, const UsableScan& first,
                         const UsableScan& second, std::size_t first_knot,
                         const RegistrationSettings& settings)
    : knots_(std::move(knots)),
      prior_(std::move(prior)),
      first_(first),
      second_(second),
      first_interval_(first.interval - first_knot),
      settings_(settings),
      rough_(every_so_often(first.points, kRoughPoints)) {}

WindowPrior PairOfScans::expected(const Vector6d& varpi, double speed_sigma, double turn_rate_sigma) const {
  WindowPrior out = prior_;
  out.mean.front().varpi = varpi;
  Vector6d sigma;
  sigma << Eigen::Vector3d::Constant(speed_sigma), Eigen::Vector3d::Constant(turn_rate_sigma);
  out.diagonal.front().bottomRightCorner<6, 6>() = sigma.cwiseInverse().cwiseAbs2().asDiagonal();
  return out;
}

// Steps with cubes and gates `scale` times as large.
bool PairOfScans::improve_at(double scale, int steps, bool rough, const WindowPrior& prior,
                             Registration& registration) const {
  RegistrationSettings level = settings_;
  level.weights.gate_m *= scale;
  registration.converged = false;
  for (int i = 0; i < steps && !registration.converged; ++i) {
    std::vector<PlaneNear> planes;
    const PlaneMap map = map_of(registration, scale, rough);
    if (!improve(prior, second_.bins, map, level, planes, registration)) return false;
  }
  return true;
}

PlaneMap PairOfScans::map_of(const Registration& registration, double scale, bool rough) const {
  const auto& points = rough ? rough_ : first_.points;
  PlaneMap map(scale * settings_.sigma_m, scale, kGrids);
  auto points_0 = points_in_world(points, first_.start, registration.knots[first_interval_],
                                  registration.knots[first_interval_ + 1]);
  for (MapPoint& point : points_0) point.range_m /= scale;
  (void)map.insert(points_0);
  return map;
}

bool PairOfScans::refine(Registration& registration) const {
  const WindowPrior prior = expected(registration.knots.back().varpi, kSpeedSigma, kTurnRateSigma);
  registration.iterations = 0;
  for (double scale = kCoarsestScale / 2; scale > 1; scale /= 2) {
    if (!improve_at(scale, kRoughSteps, false, prior, registration)) return false;
  }
  return improve_at(1, settings_.max_iterations, false, prior, registration);
}

std::optional<Registration> PairOfScans::roughly(const Vector6d& varpi) const {
  const WindowPrior prior = expected(varpi, kSpeedSigma, kTurnRateSigma);
  Registration out = moving_with(knots_, varpi);
  if (!improve_at(kCoarsestScale, kRoughSteps, true, prior, out)) return std::nullopt;
  if (!improve_at(1, 2, true, prior, out)) return std::nullopt;
  return out;
}

std::vector<Registration> PairOfScans::all_roughly() const {
  std::vector<Registration> found =
      for_each(velocities_to_try(), [&](const Vector6d& varpi) { return roughly(varpi); });
  std::stable_sort(found.begin(), found.end(), has_more_agreement);
  std::vector<Registration> distinct;
  for (Registration& registration : found) {
    if (distinct.size() < kRefined && !is_known(distinct, registration))
      distinct.push_back(std::move(registration));
  }
  return distinct;
}

// Keeps to the speed along the direction, but says how uncertain it is without.
std::optional<Registration> PairOfScans::held(const Vector6d& varpi, const Eigen::Vector3d& direction) const {
  WindowPrior prior = expected(varpi, kSpeedSigma, kTurnRateSigma);
  Registration free = moving_with(knots_, varpi);
  if (!improve_at(1, 1, true, prior, free)) return std::nullopt;
  prior.diagonal.front().block<3, 3>(6, 6) += direction * direction.transpose() / (kHeldSigma * kHeldSigma);
  Registration out = moving_with(knots_, varpi);
  if (!improve_at(1, kRoughSteps, true, prior, out)) return std::nullopt;
  out.last_information = free.last_information;
  out.known = prior_of(out.knots.back(), free.last_information);
  return out;
}

// Motions that differ along the directions that the best one is hardly held in.
void PairOfScans::add_along_weak(std::vector<Registration>& all) const {
  const Registration best = all.front();
  const Degeneracy& degeneracy = best.degeneracy;
  for (Eigen::Index i = 0; i < 3 && degeneracy.constraint_ratio[i] * best.matched < kWeaklyHeld; ++i) {
    const Eigen::Vector3d direction = degeneracy.directions_v.col(i);
    const double speed_along = direction.dot(best.knots.back().varpi.head<3>());
    std::vector<Vector6d> velocities;
    for (int step = -kSpeedSteps; step <= kSpeedSteps; ++step) {
      velocities.push_back(best.knots.back().varpi);
      velocities.back().head<3>() += (kSpeedStep * step - speed_along) * direction;
    }
    const auto along = for_each(velocities, [&](const Vector6d& varpi) { return held(varpi, direction); });
    for (const Registration& registration : along) add_unless_known(all, registration);
  }
}

std::vector<Registration> PairOfScans::register_all() const {
  const auto refined = for_each(all_roughly(), [&](Registration candidate) -> std::optional<Registration> {
    if (!refine(candidate)) return std::nullopt;
    return candidate;
  });
  std::vector<Registration> out;
  for (const Registration& registration : refined) add_unless_known(out, registration);
  if (!out.empty()) add_along_weak(out);
  return out;
}

std::optional<Registration> PairOfScans::register_near(const Vector6d& varpi) const {
  const WindowPrior prior = expected(varpi, kNearSpeedSigma, kNearTurnRateSigma);
  Registration out = moving_with(knots_, varpi);
  if (!improve_at(1, settings_.max_iterations, false, prior, out)) return std::nullopt;
  return out;
}

}  // namespace mapless
