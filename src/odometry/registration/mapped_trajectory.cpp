#include "odometry/registration/mapped_trajectory.hpp"

#include <algorithm>

#include <Eigen/LU>

#include "odometry/map/points_in_world.hpp"
#include "odometry/solver/motion_density.hpp"

namespace mapless::inline v1 {
namespace {

// What is known of a sensor before its first scan: where it is, by definition, and hardly how it moves.
constexpr double kOriginSigma = 1e-5;      // [m], [rad]
constexpr double kFirstSpeedSigma = 30;    // [m/s]
constexpr double kFirstTurnRateSigma = 5;  // [rad/s]
// Scans whose points can still be taken out. A detector that looks one scan ahead, as ours does by default,
// knows of a scan after the next; ten leaves room for larger forward gaps and costs 4 MB.
constexpr std::size_t kRememberedScans = 10;
constexpr double kWidestCube = 7;               // across its corners [m]
constexpr double kForgetEvery = 10;             // metres travelled between two clearings of the map's edge
constexpr double kFarthestCorrection = 10;      // [m]
constexpr double kLargestTurnCorrection = 1.2;  // [rad]

// The start of the scan, or the first return where a laser fires before its column.
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

WindowPrior prior_of_first(const TrajectoryKnot& knot) {
  Vector12d sigma;
  sigma << Vector6d::Constant(kOriginSigma), Eigen::Vector3d::Constant(kFirstSpeedSigma),
      Eigen::Vector3d::Constant(kFirstTurnRateSigma);
  return prior_of(knot, sigma.cwiseInverse().cwiseAbs2().asDiagonal());
}

bool is_plausible(const TrajectoryKnot& found, const TrajectoryKnot& prediction) {
  const Vector6d correction = (found.T_v0 * prediction.T_v0.inverse()).log();
  return correction.allFinite() && found.varpi.allFinite() &&
         correction.head<3>().norm() < kFarthestCorrection &&
         correction.tail<3>().norm() < kLargestTurnCorrection;
}

RegistrationSettings MappedTrajectory::with_own_density(RegistrationSettings settings) const {
  settings.density = density_of(std::span(knots).first(knots.size() - 1), settings.density);
  return settings;
}

void MappedTrajectory::append_knots(const LidarScan& scan, Time end) {
  if (knots.empty()) {
    knots.push_back({start_of(scan), SE3(), Vector6d::Zero()});
    prior = prior_of_first(knots.front());
  } else if ((scan.start - knots.back().time).seconds() > 0.5 * (end - scan.start).seconds()) {
    knots.push_back(predicted(knots.back(), scan.start));
  }
  knots.push_back(predicted(knots.back(), end));
}

void MappedTrajectory::accept(const Registration& registration) {
  std::copy(registration.knots.begin(), registration.knots.end(),
            knots.begin() + static_cast<std::ptrdiff_t>(window_begin));
  if (!marginalises) return;
  prior = registration.known;
  window_begin = knots.size() - prior.mean.size();
}

Matrix12d MappedTrajectory::carry_by_prior(const RegistrationSettings& settings) {
  const auto carried =
      register_scan(window(), prior, TimeBins({}, Time(), Time()), map, with_own_density(settings));
  if (carried) {
    accept(*carried);
    return carried->last_information.inverse();
  }
  // Only for a prior that lost its last digits: the knots stay as predicted.
  begin_anew_at(knots.size() - 1);
  return Matrix12d::Zero();
}

void MappedTrajectory::begin_anew_at(std::size_t interval) {
  window_begin = interval;
  prior = prior_of_first(knots[interval]);
}

void MappedTrajectory::insert(const UsableScan& scan, double map_radius_m) {
  const auto points = points_in_world(scan.points, scan.start, knots[scan.interval], knots[scan.interval + 1],
                                      kLinesApart * inserted_scans_++);
  const std::vector<unsigned> taken = map.insert(points);
  InsertedScan& kept = inserted_.emplace_back();
  kept.start = scan.start;
  kept.points.reserve(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (taken[i] != 0) kept.points.push_back({points[i].p_0, scan.points[i].return_index, taken[i]});
  }
  if (inserted_.size() > kRememberedScans) inserted_.pop_front();
  const Eigen::Vector3d centre_0 = knots[scan.interval + 1].T_v0.inverse().translation();
  if ((centre_0 - map_cleared_at_0_).norm() >= kForgetEvery) forget_edge(centre_0, map_radius_m);
}

void MappedTrajectory::forget_edge(const Eigen::Vector3d& centre_0, double map_radius_m) {
  map_cleared_at_0_ = centre_0;
  map.keep_within(centre_0, map_radius_m);
  // A cube that is forgotten and begun anew no longer has the points it had.
  const double safe_m = map_radius_m - kWidestCube;
  for (InsertedScan& scan : inserted_) {
    std::erase_if(scan.points, [&](const auto& point) { return (point.p_0 - centre_0).norm() > safe_m; });
  }
}

void MappedTrajectory::remove_dynamic_points(const LidarScan& scan,
                                             const std::vector<std::uint16_t>& object) {
  const auto kept = std::find_if(inserted_.begin(), inserted_.end(),
                                 [&](const InsertedScan& one) { return one.start == scan.start; });
  if (kept == inserted_.end() || object.size() != scan.returns.size()) return;
  std::vector<PlaneMap::TakenPoint> moving;
  std::erase_if(kept->points, [&](const InsertedScan::Point& point) {
    if (point.return_index >= object.size() || object[point.return_index] == 0) return false;
    moving.push_back({point.p_0, point.taken});
    return true;
  });
  map.remove(moving);
}

void MappedTrajectory::clear_map() {
  map.clear();
  inserted_.clear();
}

}  // namespace mapless
