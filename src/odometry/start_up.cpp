#include "odometry/start_up.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "odometry/points_in_world.hpp"

namespace mapless {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
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
// How far from a velocity that is tried another may be found.
constexpr double kSpeedSigma = 8;     // [m/s]
constexpr double kTurnRateSigma = 1;  // [rad/s]

/// Registers a second scan to a first one whose own motion is found with it.
class PairOfScans {
 public:
  PairOfScans(KnotPrior prior, const UsableScan& first, const TimeBins& second,
              const RegistrationSettings& settings)
      : prior_(std::move(prior)), first_(first), second_(second), settings_(settings), rough_(first.points) {
    if (rough_.size() > kRoughPoints) rough_.resize(kRoughPoints);
  }

  void expect(const Vector6d& varpi) {
    prior_.mean.varpi = varpi;
    Vector6d sigma;
    sigma << Eigen::Vector3d::Constant(kSpeedSigma), Eigen::Vector3d::Constant(kTurnRateSigma);
    prior_.information.bottomRightCorner<6, 6>() = sigma.cwiseInverse().cwiseAbs2().asDiagonal();
  }

  // Steps with cubes and gates `scale` times as large.
  bool improve_at(double scale, int steps, bool rough, Registration& registration) const {
    RegistrationSettings level = settings_;
    level.weights.gate_m *= scale;
    registration.converged = false;
    for (int i = 0; i < steps && !registration.converged; ++i) {
      if (!improve(prior_, second_, map_of(registration, scale, rough), level, registration)) return false;
    }
    return true;
  }

  [[nodiscard]] const RegistrationSettings& settings() const { return settings_; }

 private:
  [[nodiscard]] PlaneMap map_of(const Registration& registration, double scale, bool rough) const {
    const auto& points = rough ? rough_ : first_.points;
    PlaneMap map(scale * settings_.sigma_m, scale, kGrids);
    const auto points_0 = points_in_world(points, first_.start, registration.knots[first_.interval],
                                          registration.knots[first_.interval + 1]);
    for (std::size_t i = 0; i < points.size(); ++i)
      (void)map.insert(points_0[i], static_cast<unsigned>(points[i].laser), points[i].range_m / scale);
    return map;
  }

  KnotPrior prior_;
  const UsableScan& first_;
  const TimeBins& second_;
  const RegistrationSettings& settings_;
  std::vector<ScanPoint> rough_;
};

std::vector<Vector6d> velocities_to_try() {
  std::vector<Vector6d> out = {Vector6d::Zero()};
  for (const double speed : {10., 20., 30., 40.}) {
    for (const int axis : {0, 1}) {
      for (const double sign : {1., -1.}) out.push_back(sign * speed * Vector6d::Unit(axis));
    }
  }
  for (const double turn : {1.7, -1.7, 3.4, -3.4}) out.push_back(turn * Vector6d::Unit(5));
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

bool is_better(const Registration& a, const Registration& b) {
  const double margin = is_nearly_at_rest(b) ? kClearlyBetter * std::sqrt(b.agreement) : 0;
  return a.agreement > b.agreement + margin;
}

bool refine(const PairOfScans& pair, Registration& registration) {
  registration.iterations = 0;
  for (double scale = kCoarsestScale / 2; scale > 1; scale /= 2) {
    if (!pair.improve_at(scale, kRoughSteps, false, registration)) return false;
  }
  return pair.improve_at(1, pair.settings().max_iterations, false, registration);
}

}  // namespace

std::optional<Registration> start_up(const std::vector<TrajectoryKnot>& knots, const KnotPrior& prior,
                                     const UsableScan& first, const TimeBins& second,
                                     const RegistrationSettings& settings) {
  PairOfScans pair(prior, first, second, settings);
  std::vector<Registration> found;
  for (const Vector6d& varpi : velocities_to_try()) {
    pair.expect(varpi);
    Registration rough = moving_with(knots, varpi);
    if (pair.improve_at(kCoarsestScale, kRoughSteps, true, rough) && pair.improve_at(1, 2, true, rough))
      found.push_back(std::move(rough));
  }
  std::vector<double> agreements;
  for (const Registration& rough : found) agreements.push_back(rough.agreement);
  std::sort(agreements.begin(), agreements.end(), std::greater<>());
  const double least = agreements.size() > kRefined ? agreements[kRefined - 1] : -kInfinity;
  std::optional<Registration> best;
  for (std::size_t i = 0; i < found.size(); ++i) {
    Registration& candidate = found[i];
    if (i > 0 && candidate.agreement < least) continue;
    pair.expect(candidate.knots.back().varpi);
    if (!refine(pair, candidate)) continue;
    if (!best || is_better(candidate, *best)) best = std::move(candidate);
  }
  return best;
}

}  // namespace mapless
