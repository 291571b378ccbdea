#include <algorithm>
#include <cmath>
#include <deque>
#include <optional>
#include <string>

#include <Eigen/LU>

#include "odometry/knot_trajectory.hpp"
#include "odometry/points_in_world.hpp"
#include "odometry/start_up.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/odometry/lidar_odometry.hpp>

namespace mapless {
namespace {

// What is known of a sensor before its first scan: where it is, by definition, and hardly how it moves.
constexpr double kOriginSigma = 1e-5;      // [m], [rad]
constexpr double kFirstSpeedSigma = 30;    // [m/s]
constexpr double kFirstTurnRateSigma = 5;  // [rad/s]
constexpr std::size_t kFewestKeypoints = 50;
constexpr unsigned kLinesApart = 29;  // numbers of the lines of two scans: odd, so that they fall apart
constexpr int kDenserAtFirst = 3;     // points of the first two scans, the only ones there are for each other
constexpr int kLostBeforeRestart = 5;
constexpr std::size_t kRememberedScans = 10;
constexpr double kWidestCube = 7;    // across its corners [m]
constexpr double kForgetEvery = 10;  // metres travelled between two clearings of the map's edge
// A registration that leaves the prediction by more than this found something else.
constexpr double kFarthestCorrection = 10;      // [m]
constexpr double kLargestTurnCorrection = 1.2;  // [rad]

KnotPrior prior_of_first(const TrajectoryKnot& knot) {
  Vector12d sigma;
  sigma << Vector6d::Constant(kOriginSigma), Eigen::Vector3d::Constant(kFirstSpeedSigma),
      Eigen::Vector3d::Constant(kFirstTurnRateSigma);
  return {knot, sigma.cwiseInverse().cwiseAbs2().asDiagonal()};
}

TrajectoryKnot predicted(const TrajectoryKnot& knot, Time t) {
  return {t, (SE3::exp((t - knot.time).seconds() * knot.varpi) * knot.T_v0).normalized(), knot.varpi};
}

// The start of the scan, or the first return where a laser fires before its column.
Time start_of(const LidarScan& scan) {
  Time start = scan.start;
  for (const LidarReturn& r : scan.returns) start = std::min(start, scan.time_of(r));
  return start;
}

// The end of the scan, or the last return where that is later.
Time end_of(const LidarScan& scan) {
  Time end = scan.end();
  for (const LidarReturn& r : scan.returns) end = std::max(end, scan.time_of(r));
  return end;
}

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
          p.min_direction_share,
          p.max_iterations};
}

bool is_plausible(const TrajectoryKnot& found, const TrajectoryKnot& prediction) {
  const Vector6d correction = (found.T_v0 * prediction.T_v0.inverse()).log();
  return correction.allFinite() && found.varpi.allFinite() &&
         correction.head<3>().norm() < kFarthestCorrection &&
         correction.tail<3>().norm() < kLargestTurnCorrection;
}

}  // namespace

namespace {

/// What the map took of a scan.
struct InsertedScan {
  struct Point {
    Eigen::Vector3d p_0;
    std::uint32_t return_index;
    unsigned taken;  // by which grids
  };
  Time start;
  std::vector<Point> points;
};

}  // namespace

struct LidarOdometry::State {
  explicit State(const OdometryParameters& p)
      : parameters(p), settings(settings_of(p)), trajectory(knots), map(p.residual_sigma_m) {}

  OdometryParameters parameters;
  RegistrationSettings settings;
  std::vector<TrajectoryKnot> knots;
  KnotTrajectory trajectory;
  std::size_t window_begin = 0;  // first knot that can still change
  KnotPrior prior;               // of that knot
  PlaneMap map;
  Eigen::Vector3d map_cleared_at_0 = Eigen::Vector3d::Zero();
  std::shared_ptr<const LidarScan> last_scan;
  std::optional<UsableScan> first_scan;  // until the motion during it is known
  unsigned inserted_scans = 0;
  std::deque<InsertedScan> inserted;  // the last ones
  bool started = false;
  int lost_in_a_row = 0;

  void require_next(const LidarScan& scan) const;
  void append_knots(const LidarScan& scan);
  [[nodiscard]] std::vector<TrajectoryKnot> window() const {
    return {knots.begin() + static_cast<std::ptrdiff_t>(window_begin), knots.end()};
  }
  void accept(const Registration& registration);
  void carry_by_prior(OdometryUpdate& update);
  void forget_window();
  void insert(const UsableScan& scan);
  void forget_edge(const Eigen::Vector3d& centre_0);
  void leave_out(const LidarScan& scan, const std::vector<std::uint16_t>& object);
  ScanOutcome begin_with(UsableScan scan);
  std::optional<Registration> registered(const TimeBins& bins, OdometryUpdate& update) const;
  ScanOutcome start(UsableScan scan, const TimeBins& bins, OdometryUpdate& update);
  ScanOutcome track(const UsableScan& scan, const TimeBins& bins, OdometryUpdate& update);
  ScanOutcome estimate(const std::shared_ptr<const LidarScan>& scan, OdometryUpdate& update);
  OdometryUpdate process(const std::shared_ptr<const LidarScan>& scan);
};

void LidarOdometry::State::require_next(const LidarScan& scan) const {
  if (scan.compensated_to) {
    throw InputError({"", "scan", "already compensated for motion", "odometry needs the points as measured",
                      "give the poses the recording was compensated with (--trajectory)"});
  }
  if (scan.columns <= 0 || scan.column_period.nanoseconds() <= 0) {
    throw InputError({"", "scan", std::to_string(scan.columns) + " columns", "has no duration",
                      "give scans of at least one column"});
  }
  if (knots.empty() || (scan.start > last_scan->start && end_of(scan) > knots.back().time)) return;
  throw InputError({"", "scan start", std::to_string(scan.start.nanoseconds()) + " ns",
                    "not after the scan before it", "give scans by increasing time"});
}

// A knot at the end of the scan, and one at its start where scans are missing before it.
void LidarOdometry::State::append_knots(const LidarScan& scan) {
  const Time end = end_of(scan);
  if (knots.empty()) {
    knots.push_back({start_of(scan), SE3(), Vector6d::Zero()});
    prior = prior_of_first(knots.front());
  } else if ((scan.start - knots.back().time).seconds() > 0.5 * (end - scan.start).seconds()) {
    knots.push_back(predicted(knots.back(), scan.start));
  }
  knots.push_back(predicted(knots.back(), end));
}

// Marginalises all knots but the last, once the motion of the first scan is known.
void LidarOdometry::State::accept(const Registration& registration) {
  std::copy(registration.knots.begin(), registration.knots.end(),
            knots.begin() + static_cast<std::ptrdiff_t>(window_begin));
  if (!started) return;
  window_begin = knots.size() - 1;
  prior = {knots.back(), registration.last_information};
}

void LidarOdometry::State::carry_by_prior(OdometryUpdate& update) {
  const auto carried = register_scan(window(), prior, TimeBins({}, Time(), Time()), map, settings);
  if (!carried) return forget_window();
  accept(*carried);
  update.covariance = carried->last_information.inverse();
}

// Only for a prior that lost its last digits: the knots stay as predicted.
void LidarOdometry::State::forget_window() {
  prior = prior_of_first(knots.back());
  window_begin = knots.size() - 1;
}

void LidarOdometry::State::insert(const UsableScan& scan) {
  const auto points_0 =
      points_in_world(scan.points, scan.start, knots[scan.interval], knots[scan.interval + 1]);
  const unsigned first_line = kLinesApart * inserted_scans++;
  InsertedScan& kept = inserted.emplace_back();
  kept.start = scan.start;
  for (std::size_t i = 0; i < points_0.size(); ++i) {
    const ScanPoint& p = scan.points[i];
    const unsigned taken = map.insert(points_0[i], first_line + static_cast<unsigned>(p.laser), p.range_m);
    if (taken != 0) kept.points.push_back({points_0[i], p.return_index, taken});
  }
  if (inserted.size() > kRememberedScans) inserted.pop_front();
  const Eigen::Vector3d centre_0 = knots[scan.interval + 1].T_v0.inverse().translation();
  if ((centre_0 - map_cleared_at_0).norm() >= kForgetEvery) forget_edge(centre_0);
}

void LidarOdometry::State::forget_edge(const Eigen::Vector3d& centre_0) {
  map_cleared_at_0 = centre_0;
  map.keep_within(centre_0, parameters.map_radius_m);
  // A cube that is forgotten and begun anew no longer has the points it had.
  const double safe_m = parameters.map_radius_m - kWidestCube;
  for (InsertedScan& scan : inserted) {
    std::erase_if(scan.points, [&](const auto& point) { return (point.p_0 - centre_0).norm() > safe_m; });
  }
}

void LidarOdometry::State::leave_out(const LidarScan& scan, const std::vector<std::uint16_t>& object) {
  const auto kept = std::find_if(inserted.begin(), inserted.end(),
                                 [&](const InsertedScan& one) { return one.start == scan.start; });
  if (kept == inserted.end() || object.size() != scan.returns.size()) return;
  std::erase_if(kept->points, [&](const InsertedScan::Point& point) {
    if (point.return_index >= object.size() || object[point.return_index] == 0) return false;
    map.remove(point.p_0, point.taken);
    return true;
  });
}

ScanOutcome LidarOdometry::State::begin_with(UsableScan scan) {
  first_scan = std::move(scan);
  return ScanOutcome::first;
}

// Nothing where the registration is not to be believed; `update` then still says what was seen of it.
std::optional<Registration> LidarOdometry::State::registered(const TimeBins& bins,
                                                             OdometryUpdate& update) const {
  auto found = started ? register_scan(window(), prior, bins, map, settings)
                       : start_up(window(), prior, *first_scan, bins, settings);
  if (!found) return std::nullopt;
  update.iterations = found->iterations;
  update.matched_share = static_cast<double>(found->matched) / static_cast<double>(bins.points().size());
  update.degeneracy = found->degeneracy;
  if (update.matched_share < parameters.min_matched_share) return std::nullopt;
  if (!is_plausible(found->knots.back(), knots.back())) return std::nullopt;
  update.converged = found->converged;
  update.covariance = found->last_information.inverse();
  return found;
}

ScanOutcome LidarOdometry::State::start(UsableScan scan, const TimeBins& bins, OdometryUpdate& update) {
  const auto found = registered(bins, update);
  if (!found) {
    carry_by_prior(update);
    begin_with(std::move(scan));
    return ScanOutcome::lost;
  }
  started = true;
  accept(*found);
  insert(*first_scan);
  insert(scan);
  first_scan.reset();
  return ScanOutcome::registered;
}

ScanOutcome LidarOdometry::State::track(const UsableScan& scan, const TimeBins& bins,
                                        OdometryUpdate& update) {
  if (const auto found = registered(bins, update)) {
    lost_in_a_row = 0;
    accept(*found);
    insert(scan);
    return ScanOutcome::registered;
  }
  carry_by_prior(update);
  if (++lost_in_a_row < kLostBeforeRestart) return ScanOutcome::lost;
  lost_in_a_row = 0;
  map.clear();
  inserted.clear();
  insert(scan);
  return ScanOutcome::restarted;
}

ScanOutcome LidarOdometry::State::estimate(const std::shared_ptr<const LidarScan>& scan,
                                           OdometryUpdate& update) {
  if (last_scan && same_returns(*last_scan, *scan)) {
    carry_by_prior(update);
    return ScanOutcome::repeated;
  }
  OdometryParameters used = parameters;
  if (!started) {
    used.max_scan_points *= kDenserAtFirst;
    used.min_keypoints *= kDenserAtFirst;
  }
  UsableScan usable = {thin(*scan, used), scan->start, knots.size() - 2};
  const TimeBins bins(select_keypoints(usable.points, used), scan->start, knots[usable.interval].time);
  if (bins.points().size() < kFewestKeypoints) {
    carry_by_prior(update);
    return ScanOutcome::few_points;
  }
  if (started) return track(usable, bins, update);
  if (first_scan) return start(std::move(usable), bins, update);
  carry_by_prior(update);
  return begin_with(std::move(usable));
}

OdometryUpdate LidarOdometry::State::process(const std::shared_ptr<const LidarScan>& scan) {
  require_next(*scan);
  const std::size_t first_changed = window_begin;
  append_knots(*scan);
  OdometryUpdate update;
  update.outcome = estimate(scan, update);
  last_scan = scan;
  update.knots.assign(knots.begin() + static_cast<std::ptrdiff_t>(first_changed), knots.end());
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
void LidarOdometry::leave_out(const LidarScan& scan, const std::vector<std::uint16_t>& object) {
  state_->leave_out(scan, object);
}
bool LidarOdometry::started() const { return state_->started; }
const std::vector<TrajectoryKnot>& LidarOdometry::knots() const { return state_->knots; }
const Trajectory& LidarOdometry::trajectory() const { return state_->trajectory; }

}  // namespace mapless
