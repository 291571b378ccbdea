#include <algorithm>
#include <optional>
#include <string>

#include <Eigen/LU>

#include "odometry/solver/knot_chunks.hpp"
#include "odometry/solver/knot_trajectory.hpp"
#include "odometry/start_up/start_up.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/odometry/lidar_odometry.hpp>

namespace mapless::inline v1 {
namespace {

constexpr std::size_t kFewestKeypoints = 50;
constexpr int kDenserAtFirst = 3;  // points of the first scans, the only ones there are for each other
// Where no more than so many of the matched points hold a direction (share x matched: the mean square of
// (plane normal . direction), summed), the next scan is registered with so many times as many.
constexpr double kFewHolding = 5;
constexpr int kMoreWhereWeak = 3;
// To have as many as that, cubes are halved so many times at most. More would be the ground about the sensor.
constexpr int kHalvings = 2;
constexpr int kHalvingsWhereWeak = 3;
constexpr int kLostBeforeRestart = 5;
// A scan of which so much less matches than of the one before it is tried again (from one scan to the next
// the share changes by 1 to 2 %), and one of which far less matches than usual is not believed to have
// converged.
constexpr double kOfLast = 0.95;
constexpr double kFarBelowUsual = 0.6;
constexpr double kUsualForgets = 0.05;  // a scan

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

double inlier_ratio(const Registration& registration, const TimeBins& bins) {
  return static_cast<double>(registration.matched) / static_cast<double>(bins.points().size());
}

void tell(const Registration& registration, const TimeBins& bins, OdometryUpdate& update) {
  update.iterations = registration.iterations;
  update.inlier_ratio = inlier_ratio(registration, bins);
  update.degeneracy = registration.degeneracy;
}

}  // namespace

struct LidarOdometry::State {
  explicit State(const OdometryParameters& p)
      : parameters(p), settings(settings_of(p)), trajectory(knots), track(p.residual_sigma_m) {
    start_up.emplace(parameters, settings);
  }

  OdometryParameters parameters;
  RegistrationSettings settings;
  std::vector<TrajectoryKnot> knots;  // the track's, where nobody moves them
  KnotTrajectory trajectory;
  KnotChunks final_knots;           // those that no scan corrects any more
  std::optional<StartUp> start_up;  // until the motion is known
  MappedTrajectory track;           // from then on
  std::shared_ptr<const LidarScan> last_scan;
  int lost_in_a_row = 0;
  double last_share = 0;     // of matched points, in the scan before
  double usual_share = 0;    // the same, in the scans before
  bool weakly_held = false;  // some direction, by the points of the scan before

  [[nodiscard]] const MappedTrajectory& known() const { return start_up ? start_up->best() : track; }
  void require_next(const LidarScan& scan, Time end) const;
  void append_knots(const LidarScan& scan, Time end);
  Matrix12d carry_by_prior();
  [[nodiscard]] UsableScan usable(const LidarScan& scan) const;
  ScanOutcome start(UsableScan scan, OdometryUpdate& update);
  [[nodiscard]] std::optional<Registration> registered(const UsableScan& scan) const;
  ScanOutcome follow(const UsableScan& scan, OdometryUpdate& update);
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
  if (knots.empty() || (scan.start > last_scan->start && end > knots.back().time)) return;
  throw InputError({"", "scan start", std::to_string(scan.start.nanoseconds()) + " ns",
                    "not after the scan before it", "give scans by increasing time"});
}

void LidarOdometry::State::append_knots(const LidarScan& scan, Time end) {
  if (start_up) {
    start_up->append_knots(scan, end);
  } else {
    track.append_knots(scan, end);
  }
}

Matrix12d LidarOdometry::State::carry_by_prior() {
  return start_up ? start_up->carry_by_prior() : track.carry_by_prior(settings);
}

UsableScan LidarOdometry::State::usable(const LidarScan& scan) const {
  OdometryParameters used = parameters;
  if (start_up) {
    used.max_scan_points *= kDenserAtFirst;
    used.min_keypoints *= kDenserAtFirst;
  } else if (weakly_held) {
    used.min_keypoints *= kMoreWhereWeak;
  }
  const int halvings = !start_up && weakly_held ? kHalvingsWhereWeak : kHalvings;
  const std::size_t interval = known().knots.size() - 2;
  std::vector<ScanPoint> points = thin(scan, used);
  TimeBins bins(select_keypoints(points, used, halvings), scan.start, known().knots[interval].time);
  return {std::move(points), std::move(bins), start_up ? std::make_shared<const SeenThrough>(scan) : nullptr,
          scan.start, interval};
}

ScanOutcome LidarOdometry::State::start(UsableScan scan, OdometryUpdate& update) {
  if (!start_up->has_first()) {
    update.covariance = start_up->carry_by_prior();
    start_up->begin_with(std::move(scan));
    return ScanOutcome::first;
  }
  const TimeBins bins = scan.bins;
  const auto [found, ambiguous] = start_up->add(std::move(scan));
  if (!found) return ScanOutcome::lost;
  tell(*found, bins, update);
  update.covariance = found->last_information.inverse();
  update.converged = found->converged;
  update.ambiguous = ambiguous;
  if (start_up->decided()) {
    last_share = usual_share = update.inlier_ratio;
    track = start_up->best();
    start_up.reset();
  }
  return ScanOutcome::registered;
}

// What was not to be expected of the motion so far is registered as if nothing was known of it.
std::optional<Registration> LidarOdometry::State::registered(const UsableScan& scan) const {
  auto found =
      register_scan(track.window(), track.prior, scan.bins, track.map, track.with_own_density(settings));
  if (found && found->converged && inlier_ratio(*found, scan.bins) >= kOfLast * last_share) return found;
  auto again = register_widely(track.window(), track.prior, scan.bins, track.map, settings);
  return again && (!found || again->agreement > found->agreement) ? again : found;
}

// Where the registration is not to be believed, `update` still says what was seen of it.
ScanOutcome LidarOdometry::State::follow(const UsableScan& scan, OdometryUpdate& update) {
  const auto found = registered(scan);
  if (found) tell(*found, scan.bins, update);
  if (found && update.inlier_ratio >= parameters.min_inlier_ratio &&
      is_plausible(found->knots.back(), track.knots.back())) {
    update.converged = found->converged && update.inlier_ratio >= kFarBelowUsual * usual_share;
    last_share = update.inlier_ratio;
    const double holding = found->degeneracy.constraint_ratio[0] * found->matched;
    // Three times as many matched are three times as much, of the same hold.
    weakly_held = holding < (weakly_held ? kMoreWhereWeak : 1) * kFewHolding;
    usual_share += kUsualForgets * (update.inlier_ratio - usual_share);
    update.covariance = found->last_information.inverse();
    lost_in_a_row = 0;
    track.accept(*found);
    track.insert(scan, parameters.map_radius_m);
    return ScanOutcome::registered;
  }
  update.covariance = track.carry_by_prior(settings);
  if (++lost_in_a_row < kLostBeforeRestart) return ScanOutcome::lost;
  lost_in_a_row = 0;
  track.clear_map();
  track.insert(scan, parameters.map_radius_m);
  return ScanOutcome::restarted;
}

ScanOutcome LidarOdometry::State::estimate(const LidarScan& scan, OdometryUpdate& update) {
  if (last_scan && same_returns(*last_scan, scan)) {
    update.covariance = carry_by_prior();
    return ScanOutcome::repeated;
  }
  UsableScan points = usable(scan);
  if (points.bins.points().size() < kFewestKeypoints) {
    update.covariance = carry_by_prior();
    return ScanOutcome::few_points;
  }
  return start_up ? start(std::move(points), update) : follow(points, update);
}

OdometryUpdate LidarOdometry::State::process(const std::shared_ptr<const LidarScan>& scan) {
  const Time end = end_of(*scan);
  require_next(*scan, end);
  const std::size_t first_changed = start_up ? 0 : track.window_begin;
  append_knots(*scan, end);
  OdometryUpdate update;
  update.outcome = estimate(*scan, update);
  last_scan = scan;
  const auto changed = static_cast<std::ptrdiff_t>(first_changed);
  update.knots.assign(known().knots.begin() + changed, known().knots.end());
  knots.resize(known().knots.size());
  std::copy(update.knots.begin(), update.knots.end(), knots.begin() + changed);
  final_knots.update(knots, start_up ? 0 : track.window_begin);
  return update;
}

LidarOdometry::LidarOdometry(const OdometryParameters& parameters)
    : state_(std::make_unique<State>(parameters)) {}
LidarOdometry::~LidarOdometry() = default;
LidarOdometry::LidarOdometry(LidarOdometry&&) noexcept = default;
LidarOdometry& LidarOdometry::operator=(LidarOdometry&&) noexcept = default;

OdometryUpdate LidarOdometry::process(const std::shared_ptr<const LidarScan>& scan) {
  return state_->process(scan);
}
void LidarOdometry::remove_dynamic_points(const LidarScan& scan, const std::vector<std::uint16_t>& object) {
  state_->track.remove_dynamic_points(scan, object);
}
bool LidarOdometry::started() const { return !state_->start_up; }
const std::vector<TrajectoryKnot>& LidarOdometry::knots() const { return state_->knots; }
const Trajectory& LidarOdometry::trajectory() const { return state_->trajectory; }
std::shared_ptr<const Trajectory> LidarOdometry::trajectory_snapshot() const {
  return state_->final_knots.snapshot(state_->knots);
}

}  // namespace mapless
