#include "odometry/registration/mapped_trajectory.hpp"

#include <algorithm>

#include <Eigen/LU>

#include "odometry/map/points_in_world.hpp"
#include "odometry/solver/motion_density.hpp"

namespace mapless::inline v1 {
namespace {

// The prior of the first knot. Its pose is the origin by definition: a standard deviation far below any
// residual, large enough for the system to stay well conditioned.
constexpr double kOriginSigma = 1e-5;  // [m], [rad]
// Its velocity may be that of a car on a motorway (110 km/h) or of a fast turn by hand (290 deg/s).
constexpr double kFirstSpeedSigma_mps = 30;
constexpr double kFirstTurnRateSigma_radps = 5;
// Scans whose points can still be removed. The default detector returns a scan one scan later; ten scans
// leave room for larger forward gaps and cost 4 MB.
constexpr std::size_t kRememberedScans = 10;
// Diagonal of the largest cube: 4 m x sqrt(3) = 6.93 m.
constexpr double kLargestDiagonal_m = 7;
// Distance travelled between two removals of the map's edge. Chosen: a tenth of the default map radius; every
// removal visits all cubes.
constexpr double kForgetEvery_m = 10;
// A correction of the prediction by more is a wrong association; over longer intervals than 0.1 s the limits
// grow in proportion, up to twice. Chosen: 10 m in 0.1 s is a change of speed by 100 m/s, 1.2 rad one of the
// turn rate by 690 deg/s; and the start, which predicts rest, moves by 9 m in two such scans at 45 m/s.
constexpr double kMaxCorrection_m = 10;
constexpr double kMaxCorrection_rad = 1.2;
constexpr double kCorrectionIn_s = 0.1;
constexpr double kMostTimesLonger = 2;
// Scans are missing if the last knot is earlier than this part of a scan before the start of the next.
constexpr double kMaxGapRatio = 0.5;

// The start of the scan, or its first return if a laser fires before its column.
Time start_of(const LidarScan& scan) {
  Time start = scan.start;
  for (const LidarReturn& r : scan.returns) start = std::min(start, scan.time_of(r));
  return start;
}

}  // namespace

TrajectoryKnot predicted(const TrajectoryKnot& knot, Time t) {
  return {t, (SE3::exp((t - knot.time).seconds() * knot.varpi) * knot.T_v0).normalized(), knot.varpi};
}

Time end_of(const LidarScan& scan) {
  Time end = scan.end();
  for (const LidarReturn& r : scan.returns) end = std::max(end, scan.time_of(r));
  return end;
}

WindowPrior origin_prior(const TrajectoryKnot& knot) {
  Vector12d sigma;
  sigma << Vector6d::Constant(kOriginSigma), Eigen::Vector3d::Constant(kFirstSpeedSigma_mps),
      Eigen::Vector3d::Constant(kFirstTurnRateSigma_radps);
  return prior_of(knot, sigma.cwiseInverse().cwiseAbs2().asDiagonal());
}

bool is_plausible(const TrajectoryKnot& found, const TrajectoryKnot& prediction, double interval_s) {
  const Vector6d correction = (found.T_v0 * prediction.T_v0.inverse()).log() /
                              std::clamp(interval_s / kCorrectionIn_s, 1.0, kMostTimesLonger);
  return correction.allFinite() && found.varpi.allFinite() &&
         correction.head<3>().norm() < kMaxCorrection_m && correction.tail<3>().norm() < kMaxCorrection_rad;
}

double MappedTrajectory::last_interval_s() const {
  return (knots.back().time - knots[knots.size() - 2].time).seconds();
}

RegistrationSettings MappedTrajectory::with_observed_density(RegistrationSettings settings) const {
  settings.density = estimate_density(std::span(knots).first(knots.size() - 1), settings.density);
  return settings;
}

void MappedTrajectory::append_knots(const LidarScan& scan, Time end) {
  if (knots.empty()) {
    knots.push_back({start_of(scan), SE3(), Vector6d::Zero()});
    prior = origin_prior(knots.front());
  } else if ((scan.start - knots.back().time).seconds() > kMaxGapRatio * (end - scan.start).seconds()) {
    knots.push_back(predicted(knots.back(), scan.start));
  }
  knots.push_back(predicted(knots.back(), end));
}

void MappedTrajectory::accept(const Registration& registration) {
  std::copy(registration.knots.begin(), registration.knots.end(),
            knots.begin() + static_cast<std::ptrdiff_t>(window_begin));
  if (!marginalises) return;
  prior = registration.posterior;
  window_begin = knots.size() - prior.mean.size();
}

Matrix12d MappedTrajectory::extrapolate_with_prior(const RegistrationSettings& settings) {
  const auto carried = register_scan(window(), prior, TimeBins(), map, with_observed_density(settings));
  if (carried) {
    accept(*carried);
    return carried->last_information.inverse();
  }
  // The prior is singular to machine precision: the knots stay as predicted with constant velocity.
  restart_window_at(knots.size() - 1);
  return Matrix12d::Zero();
}

void MappedTrajectory::restart_window_at(std::size_t interval) {
  window_begin = interval;
  prior = origin_prior(knots[interval]);
}

void MappedTrajectory::insert(const UsableScan& scan, double map_radius_m) {
  const auto points =
      points_in_world(scan.points, scan.start, knots[scan.interval], knots[scan.interval + 1]);
  const std::vector<unsigned> grids = map.insert(points);
  InsertedScan& kept = inserted_.emplace_back();
  kept.start = scan.start;
  kept.points.reserve(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (grids[i] != 0) kept.points.push_back({points[i].p_0, scan.points[i].return_index, grids[i]});
  }
  if (inserted_.size() > kRememberedScans) inserted_.pop_front();
  const Eigen::Vector3d centre_0 = knots[scan.interval + 1].T_v0.inverse().translation();
  if ((centre_0 - map_cleared_at_0_).norm() >= kForgetEvery_m) forget_edge(centre_0, map_radius_m);
}

void MappedTrajectory::forget_edge(const Eigen::Vector3d& centre_0, double map_radius_m) {
  map_cleared_at_0_ = centre_0;
  map.keep_within(centre_0, map_radius_m);
  // A cube that was removed and created again does not hold its old points, so that these cannot be removed.
  const double safe_m = map_radius_m - kLargestDiagonal_m;
  for (InsertedScan& scan : inserted_) {
    std::erase_if(scan.points, [&](const auto& point) { return (point.p_0 - centre_0).norm() > safe_m; });
  }
}

void MappedTrajectory::remove_dynamic_points(const LidarScan& scan,
                                             const std::vector<std::uint16_t>& object) {
  const auto kept = std::find_if(inserted_.begin(), inserted_.end(),
                                 [&](const InsertedScan& one) { return one.start == scan.start; });
  if (kept == inserted_.end() || object.size() != scan.returns.size()) return;
  std::vector<PlaneMap::InsertedPoint> dynamic;
  std::erase_if(kept->points, [&](const InsertedScan::Point& point) {
    if (point.return_index >= object.size() || object[point.return_index] == 0) return false;
    dynamic.push_back({point.p_0, point.grids});
    return true;
  });
  map.remove(dynamic);
}

void MappedTrajectory::clear_map() {
  map.clear();
  inserted_.clear();
}

}  // namespace mapless
