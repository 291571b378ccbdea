#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>

#include <Eigen/LU>

#include "odometry/keypoints/edges.hpp"
#include "odometry/registration/degeneracy.hpp"
#include "odometry/registration/motion_support.hpp"
#include "odometry/registration/recent_edges.hpp"
#include "odometry/solver/growing_trajectory.hpp"
#include "odometry/solver/motion_density.hpp"
#include "odometry/start_up/start_up.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/odometry/lidar_odometry.hpp>

namespace mapless::inline v1 {
namespace {

// Fewest keypoints for a registration. Chosen: with fewer, six unknowns are no longer clearly overdetermined.
constexpr std::size_t kMinKeypoints = 50;
// The first scans, which have only each other to register to, use this many times as many points. Measured:
// with twice as many, the joint registration of one start of 18 in a forest and one of 18 of a tilted sensor
// errs by .4 and .6 m over four scans; with half as many points, but as many keypoints, a start of an OS1-128
// above a hill errs by .7 m (docs/notebook/odometry.md, "Edges at the start", "Cost of the start").
constexpr int kStartUpDensity = 3;
// If the inliers constrain some direction by less than this many points (constraint ratio x inliers), the
// next scan is registered with three times as many keypoints. Measured (docs/notebook/odometry.md, "How many
// keypoints"): flying sensors constrain a direction by .5 to .7 points, tunnels by 3 to 7; with the limit
// flying HDL-64E err by 0.045 for 0.071 m/s; with a limit of 20 the static points of a VLP-16 on the motorway
// err by 0.034 for 0.023 m.
constexpr double kFewConstrainingPoints = 5;
constexpr int kWeakDensity = 3;
// Most halvings of the keypoint cubes (1.5 m by default). Measured: with three where a direction is weakly
// constrained, two VLP-16 motorways of the second simulator err by .058 and .017 m over four scans for .013
// and .014, and two flyers by .0074 and .0060 for .0067 and .0059; sixteen recordings are the same. In the
// first scans a third loses motorway starts: the ground near the sensor outweighs everything else.
constexpr int kMaxHalvings = 2;
// Lost scans in a row before a new map and a new start. Chosen: half a second at 10 Hz, in which the
// extrapolation errs by less than the gate at 4 m/s^2.
constexpr int kLostBeforeRestart = 5;
// A scan whose inlier ratio falls below this part of the previous one's is registered again with a wide gate.
// Measured: the ratio changes by 1 to 2 % from scan to scan unless a turn begins within one. Without the
// rule one motorway start of 20 recordings of the second simulator errs by .062 m over four scans for .058.
constexpr double kMinRatioOfLast = 0.95;

bool same_returns(const LidarScan& a, const LidarScan& b) {
  return !a.returns.empty() && std::equal(a.returns.begin(), a.returns.end(), b.returns.begin(),
                                          b.returns.end(), [](const LidarReturn& x, const LidarReturn& y) {
                                            return x.position_v == y.position_v && x.time_ns == y.time_ns;
                                          });
}

RegistrationSettings settings_of(const OdometryParameters& p) {
  return {{p.acceleration_density_translation, p.acceleration_density_rotation},
          {p.gate_m, p.robust_sigmas},
          p.residual_sigma_m,
          p.min_constraint_ratio,
          p.max_iterations};
}

double inlier_ratio_of(const Registration& registration, const TimeBins& bins) {
  return static_cast<double>(registration.inliers) / static_cast<double>(bins.points().size());
}

void report(const Registration& registration, const TimeBins& bins, OdometryUpdate& update) {
  update.iterations = registration.iterations;
  update.inlier_ratio = inlier_ratio_of(registration, bins);
  update.mean_robust_weight = registration.soft_inliers / static_cast<double>(bins.points().size());
  update.degeneracy = registration.degeneracy;
}

}  // namespace

struct LidarOdometry::State {
  explicit State(const OdometryParameters& p)
      : parameters(p), settings(settings_of(p)), mapped(p.residual_sigma_m) {
    settings.measurements = &measurements;
    start_up.emplace(parameters, settings);
  }

  OdometryParameters parameters;
  MotionMeasurements measurements;  // by time, each with its sigma; of the knots that can still change
  RegistrationSettings settings;
  GrowingTrajectory growing;
  std::shared_ptr<const Trajectory> trajectory = growing.snapshot({});  // over the knots of current()
  std::optional<StartUp> start_up;  // until the motion of the first scans is decided, and after a loss
  std::vector<std::size_t> start_up_intervals;  // the knot at the start of each scan of the start-up
  MappedTrajectory mapped;                      // without start_up
  MotionSupport support;
  RecentEdges recent_edges;       // while they are needed: up to the last registered scan
  std::optional<Time> kept_from;  // nobody asks for earlier motion
  std::shared_ptr<const LidarScan> last_scan;
  std::size_t last_interval = 0;  // the knot at its start
  int lost_in_a_row = 0;
  double last_ratio = 0;             // inlier ratio of the last registered scan
  bool weakly_constrained = false;   // the last registered scan, in some direction
  bool start_was_undecided = false;  // of the start that the last scan decided

  [[nodiscard]] const MappedTrajectory& current() const { return start_up ? start_up->best() : mapped; }
  void require_next(const LidarScan& scan, Time end) const;
  void append_knots(const LidarScan& scan, Time end);
  Matrix12d extrapolate_with_prior();
  [[nodiscard]] UsableScan select_points(const LidarScan& scan) const;
  ScanOutcome register_in_start_up(UsableScan scan, OdometryUpdate& update);
  [[nodiscard]] std::optional<Registration> register_to_map(const UsableScan& scan) const;
  ScanOutcome register_and_insert(const UsableScan& points, const LidarScan& scan, OdometryUpdate& update);
  void add_support(const UsableScan& points, const LidarScan& scan, const OdometryUpdate& update);
  ScanOutcome restart(const LidarScan& scan, OdometryUpdate& update);
  void add_measurement(MotionMeasurement measured);
  void forget_old_measurements();
  void forget_old_knots();
  void begin_start_up_again();
  [[nodiscard]] bool last_scan_is_supported(const Degeneracy& degeneracy) const;
  [[nodiscard]] MotionState state_of(const OdometryUpdate& update) const;
  [[nodiscard]] std::size_t first_open_knot() const {
    return start_up ? start_up->first_open_knot() : mapped.window_begin;
  }
  ScanOutcome estimate(const LidarScan& scan, OdometryUpdate& update);
  OdometryUpdate process(const std::shared_ptr<const LidarScan>& scan);
};

void LidarOdometry::State::require_next(const LidarScan& scan, Time end) const {
  if (scan.compensated_to) {
    throw InputError({"", "scan", "already compensated for motion", "odometry needs the points as measured",
                      "give the poses the recording was compensated with (--trajectory)"});
  }
  if (scan.columns <= 0 || scan.column_period.nanoseconds() <= 0) {
    throw InputError({"", "scan", std::to_string(scan.columns) + " columns", "has no duration",
                      "give scans of at least one column"});
  }
  const std::vector<TrajectoryKnot>& knots = current().knots;
  if (knots.empty() || (scan.start > last_scan->start && end > knots.back().time)) return;
  throw InputError({"", "scan start", std::to_string(scan.start.nanoseconds()) + " ns",
                    "not after the scan before it", "give scans by increasing time"});
}

void LidarOdometry::State::append_knots(const LidarScan& scan, Time end) {
  if (start_up) {
    start_up->append_knots(scan, end);
  } else {
    mapped.append_knots(scan, end);
  }
}

Matrix12d LidarOdometry::State::extrapolate_with_prior() {
  return start_up ? start_up->extrapolate_with_prior() : mapped.extrapolate_with_prior(settings);
}

UsableScan LidarOdometry::State::select_points(const LidarScan& scan) const {
  OdometryParameters denser = parameters;
  if (start_up) {
    denser.max_scan_points *= kStartUpDensity;
    denser.min_keypoints *= kStartUpDensity;
  } else if (weakly_constrained) {
    denser.min_keypoints *= kWeakDensity;
  }
  const std::size_t interval = current().knots.size() - 2;
  std::vector<ScanPoint> points = thin(scan, denser);
  TimeBins bins(select_keypoints(points, denser, kMaxHalvings), scan.start, current().knots[interval].time);
  return {std::move(points), std::move(bins),
          start_up ? select_edges(scan, parameters) : std::vector<ScanPoint>(), scan.start, interval};
}

ScanOutcome LidarOdometry::State::register_in_start_up(UsableScan scan, OdometryUpdate& update) {
  if (!start_up->has_first()) {
    update.covariance = start_up->extrapolate_with_prior();
    start_up->set_first(std::move(scan));
    return ScanOutcome::first;
  }
  const TimeBins bins = scan.bins;
  const auto [found, first_interval] = start_up->add(std::move(scan));
  if (!found) return ScanOutcome::unmatched;
  report(*found, bins, update);
  update.covariance = found->last_information.inverse();
  if (!start_up->decided()) return ScanOutcome::registered;
  update.decided_scans = static_cast<std::size_t>(
      std::count_if(start_up_intervals.begin(), start_up_intervals.end(),
                    [first = first_interval](std::size_t interval) { return interval >= first; }));
  last_ratio = update.inlier_ratio;
  support = {};
  support.add(update.mean_robust_weight, update.degeneracy);
  recent_edges = start_up->recent_edges();
  if (const auto agreement = recent_edges.agreement()) support.add_edges(*agreement);
  mapped = start_up->best();
  start_was_undecided = start_up->was_undecided();
  start_up.reset();
  return last_scan_is_supported(update.degeneracy) ? ScanOutcome::registered : ScanOutcome::unsupported;
}

// Point-to-plane registration to the map with the motion prior; with a wide gate if the result is doubtful.
std::optional<Registration> LidarOdometry::State::register_to_map(const UsableScan& scan) const {
  auto found = register_scan(mapped.window(), mapped.prior, scan.bins, mapped.map,
                             mapped.with_observed_density(settings));
  if (found && found->converged && inlier_ratio_of(*found, scan.bins) >= kMinRatioOfLast * last_ratio)
    return found;
  auto again = register_with_wide_gate(mapped.window(), mapped.prior, scan.bins, mapped.map, settings);
  return again && (!found || again->soft_inliers > found->soft_inliers) ? again : found;
}

void LidarOdometry::State::add_support(const UsableScan& points, const LidarScan& scan,
                                       const OdometryUpdate& update) {
  support.add(update.mean_robust_weight, update.degeneracy);
  if (!support.needs_edges() && !is_weak(update.degeneracy)) return recent_edges.clear();
  const auto add_edges = [&](const LidarScan& one, std::size_t interval) {
    recent_edges.add(edges_in_world(select_edges(one, parameters), one.start, mapped.knots[interval],
                                    mapped.knots[interval + 1]));
  };
  if (recent_edges.empty()) add_edges(*last_scan, last_interval);
  add_edges(scan, points.interval);
  if (!support.needs_edges()) return;
  if (const auto agreement = recent_edges.agreement()) support.add_edges(*agreement);
}

// If the registration is rejected, `update` still has its figures.
ScanOutcome LidarOdometry::State::register_and_insert(const UsableScan& points, const LidarScan& scan,
                                                      OdometryUpdate& update) {
  const auto found = register_to_map(points);
  if (found) report(*found, points.bins, update);
  if (!found || update.inlier_ratio < parameters.min_inlier_ratio ||
      !is_plausible(found->knots.back(), mapped.knots.back(), mapped.last_interval_s())) {
    update.covariance = mapped.extrapolate_with_prior(settings);
    return ScanOutcome::unmatched;
  }
  last_ratio = update.inlier_ratio;
  const double constraining = found->degeneracy.constraint_ratio[0] * found->inliers;
  // Three times as many keypoints constrain three times as much.
  weakly_constrained = constraining < (weakly_constrained ? kWeakDensity : 1) * kFewConstrainingPoints;
  update.covariance = found->last_information.inverse();
  mapped.accept(*found);
  add_support(points, scan, update);
  mapped.insert(points, parameters.map_radius_m);
  return last_scan_is_supported(update.degeneracy) ? ScanOutcome::registered : ScanOutcome::unsupported;
}

bool LidarOdometry::State::last_scan_is_supported(const Degeneracy& degeneracy) const {
  const std::vector<TrajectoryKnot> last = {mapped.knots.end() - 2, mapped.knots.end()};
  if (support.state() == MotionState::lost || is_contradicted(last, settings)) return false;
  const Eigen::Vector3d weakest_0 = last.back().T_v0.rotation().transpose() * degeneracy.directions_v.col(0);
  return !is_weak(degeneracy) || !recent_edges.contradict(weakest_0);
}

void LidarOdometry::State::add_measurement(MotionMeasurement measured) {
  const auto refuse = [](const char* field, double value, const char* problem, const char* remedy) {
    throw InputError({"measurement", field, std::to_string(value), problem, remedy});
  };
  const bool speed = measured.quantity == MeasuredMotion::speed;
  const std::array sigmas = {parameters.velocity_sigma_mps, parameters.speed_sigma_mps,
                             parameters.angular_velocity_sigma_radps};
  measured.sigma = measured.sigma.value_or(sigmas[static_cast<std::size_t>(measured.quantity)]);
  if (!measured.value.allFinite()) refuse("value", measured.value.sum(), "not finite", "leave it out");
  if (speed && measured.value.x() < 0)
    refuse("speed", measured.value.x(), "negative", "give the norm of the velocity");
  if (!(*measured.sigma > 0 && std::isfinite(*measured.sigma)))
    refuse("sigma", *measured.sigma, "not a finite number greater than 0", "give a standard deviation");
  const auto place = std::upper_bound(measurements.begin(), measurements.end(), measured.time,
                                      [](Time t, const MotionMeasurement& one) { return t < one.time; });
  measurements.insert(place, measured);
}

void LidarOdometry::State::forget_old_measurements() {
  const Time first = current().knots[first_open_knot()].time;
  std::erase_if(measurements, [&](const MotionMeasurement& one) { return one.time < first; });
}

// In a start-up, scans refer to knots by their numbers in all hypotheses.
void LidarOdometry::State::forget_old_knots() {
  std::vector<TrajectoryKnot>& knots = mapped.knots;
  if (start_up || !kept_from || knots.size() <= kDensityKnots) return;
  const Time first_used = knots[knots.size() - kDensityKnots].time;
  const std::size_t dropped = growing.forget_before(std::min(*kept_from, first_used));
  knots.erase(knots.begin(), knots.begin() + static_cast<std::ptrdiff_t>(dropped));
  mapped.window_begin -= dropped;
  last_interval -= dropped;
}

// Without it, a sensor that sees nothing for hours would have hours of knots that can still change.
void LidarOdometry::State::begin_start_up_again() {
  mapped = start_up->best();
  start_up.reset();
  forget_old_knots();
  start_up.emplace(parameters, settings, mapped.knots);
  start_up_intervals.clear();
  mapped = MappedTrajectory(parameters.residual_sigma_m);
}

// Begins a new map with this scan, at its extrapolated pose, without any knowledge of its velocity.
ScanOutcome LidarOdometry::State::restart(const LidarScan& scan, OdometryUpdate& update) {
  start_up.emplace(parameters, settings, mapped.knots);
  start_up_intervals = {mapped.knots.size() - 2};
  mapped = MappedTrajectory(parameters.residual_sigma_m);
  lost_in_a_row = 0;
  weakly_constrained = false;
  (void)register_in_start_up(select_points(scan), update);
  return ScanOutcome::restarted;
}

MotionState LidarOdometry::State::state_of(const OdometryUpdate& update) const {
  switch (update.outcome) {
    case ScanOutcome::first:
    case ScanOutcome::restarted:
    case ScanOutcome::registered:
      // Until the motion of the first scans is decided, it is one of several that fit them.
      if (start_up || update.degeneracy.unconstrained > 0) return MotionState::degenerate;
      if (start_was_undecided && support.state() == MotionState::good) return MotionState::degenerate;
      return support.state();
    case ScanOutcome::few_points:
    case ScanOutcome::repeated:
    case ScanOutcome::unmatched:
    case ScanOutcome::unsupported:
      break;
  }
  return MotionState::lost;
}

ScanOutcome LidarOdometry::State::estimate(const LidarScan& scan, OdometryUpdate& update) {
  if (last_scan && same_returns(*last_scan, scan)) {
    update.covariance = extrapolate_with_prior();
    return ScanOutcome::repeated;
  }
  UsableScan points = select_points(scan);
  if (points.bins.points().size() < kMinKeypoints) {
    update.covariance = extrapolate_with_prior();
    return ScanOutcome::few_points;
  }
  if (start_up) return register_in_start_up(std::move(points), update);
  const ScanOutcome outcome = register_and_insert(points, scan, update);
  lost_in_a_row = outcome == ScanOutcome::registered ? 0 : lost_in_a_row + 1;
  return lost_in_a_row < kLostBeforeRestart ? outcome : restart(scan, update);
}

// One scan (Burnett et al. 2022; method.md sections 3 and 6):
OdometryUpdate LidarOdometry::State::process(const std::shared_ptr<const LidarScan>& scan) {
  if (!scan) throw InputError({"", "scan", "null", "there is no scan", "give a scan"});
  const Time end = end_of(*scan);
  require_next(*scan, end);
  // 1. A knot at the scan's end, predicted with constant velocity.
  const std::size_t first_changed = first_open_knot();
  append_knots(*scan, end);
  const std::size_t interval = current().knots.size() - 2;
  if (start_up) start_up_intervals.push_back(interval);
  // 2. Keypoints, registered point-to-plane at their own instants with the white-noise-on-acceleration prior
  //    (Anderson and Barfoot, IROS 2015); older knots marginalised; the points inserted into the map.
  OdometryUpdate update;
  start_was_undecided = false;
  update.outcome = estimate(*scan, update);
  update.state = state_of(update);
  last_scan = scan;
  last_interval = interval;
  forget_old_measurements();
  // 3. The corrected knots, and the trajectory over all knots.
  const std::vector<TrajectoryKnot>& knots = current().knots;
  update.knots.assign(knots.begin() + static_cast<std::ptrdiff_t>(first_changed), knots.end());
  growing.update(knots, first_open_knot());
  trajectory = growing.snapshot(knots);
  if (start_up && start_up_intervals.size() >= kMostStartUpScans) begin_start_up_again();
  return update;
}

std::string_view name_of(MotionState state) {
  switch (state) {
    case MotionState::good:
      return "good";
    case MotionState::degenerate:
      return "degenerate";
    case MotionState::lost:
      return "lost";
  }
  return "";
}

LidarOdometry::LidarOdometry(const OdometryParameters& parameters) {
  require_within_bounds(parameters, "LidarOdometry");
  state_ = std::make_unique<State>(parameters);
}
LidarOdometry::~LidarOdometry() = default;
LidarOdometry::LidarOdometry(LidarOdometry&&) noexcept = default;
LidarOdometry& LidarOdometry::operator=(LidarOdometry&&) noexcept = default;

OdometryUpdate LidarOdometry::process(const std::shared_ptr<const LidarScan>& scan) {
  return state_->process(scan);
}
void LidarOdometry::add_measurement(const MotionMeasurement& measured) { state_->add_measurement(measured); }
void LidarOdometry::remove_dynamic_points(const LidarScan& scan, const std::vector<std::uint16_t>& object) {
  state_->mapped.remove_dynamic_points(scan, object);
}
void LidarOdometry::forget_before(Time t) {
  state_->kept_from = t;
  state_->forget_old_knots();
}
bool LidarOdometry::started() const { return !state_->start_up; }
const std::vector<TrajectoryKnot>& LidarOdometry::knots() const { return state_->current().knots; }
const Trajectory& LidarOdometry::trajectory() const { return *state_->trajectory; }
std::shared_ptr<const Trajectory> LidarOdometry::trajectory_snapshot() const { return state_->trajectory; }

}  // namespace mapless
