#include "run/motion_source.hpp"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include <mapless/core/errors.hpp>

namespace mapless::app {
namespace {

// Where no scan has points to register, detection goes on with a sensor that stands still. A start that stays
// open takes ten scans, and a few before them may have found no place.
constexpr std::size_t kMostWaiting = 16;

bool needs_odometry(const Dataset& dataset, const TrajectoryRequest& request, std::size_t first) {
  if (request.stationary || !request.file.empty() || dataset.trajectory() != nullptr) return false;
  // Compensated points no longer tell when they were measured; their poses are needed to undo it.
  return !dataset.read(first).compensated_to;
}

}  // namespace

MotionSource::MotionSource(const Dataset& dataset, const TrajectoryRequest& request, std::size_t first,
                           const OdometryParameters& parameters) {
  if (needs_odometry(dataset, request, first)) {
    use_odometry(parameters);
  } else {
    source_ = open_trajectory(dataset, request);
  }
}

MotionSource MotionSource::odometry(const Dataset& dataset, std::size_t first,
                                    const OdometryParameters& parameters) {
  if (dataset.read(first).compensated_to) {
    throw InputError({dataset.scan_file(first).string(), "points", "", "compensated for motion already",
                      "odometry needs them as measured: use the poses they were compensated with, the "
                      "recording's own or those of mapless detect --trajectory FILE"});
  }
  MotionSource out;
  out.use_odometry(parameters);
  return out;
}

void MotionSource::use_odometry(const OdometryParameters& parameters) {
  source_.conventions = {{"source", "estimated by lidar odometry"}};
  odometry_.emplace(parameters);
}

const Trajectory& MotionSource::trajectory() const {
  return odometry_ ? odometry_->trajectory() : *source_.trajectory;
}

std::shared_ptr<const Trajectory> MotionSource::known_from(Time from) const {
  if (!odometry_) return source_.trajectory;
  const auto& knots = odometry_->knots();
  auto first = std::upper_bound(knots.begin(), knots.end(), from,
                                [](Time time, const TrajectoryKnot& knot) { return time < knot.time; });
  if (first != knots.begin()) --first;
  return std::make_shared<const GaussianProcessTrajectory>(std::vector<TrajectoryKnot>(first, knots.end()),
                                                           "lidar odometry");
}

void MotionSource::count(const LidarScan& scan, const OdometryUpdate& update) {
  const ScanOutcome outcome = update.outcome;
  const bool registered = outcome == ScanOutcome::registered;
  if (!registered && outcome != ScanOutcome::first && report_.extrapolated++ == 0)
    report_.first_extrapolated = report_.scans;
  report_.few_points += outcome == ScanOutcome::few_points ? 1 : 0;
  report_.repeated += outcome == ScanOutcome::repeated ? 1 : 0;
  report_.lost += outcome == ScanOutcome::lost || outcome == ScanOutcome::restarted ? 1 : 0;
  report_.restarts += outcome == ScanOutcome::restarted ? 1 : 0;
  report_.degenerate += registered && update.degeneracy.unconstrained > 0 ? 1 : 0;
  report_.not_converged += registered && !update.converged ? 1 : 0;
  report_.ambiguous_start |= update.ambiguous;
  const double length_s = (scan.end() - scan.start).seconds();
  report_.gaps += report_.scans > 0 && (scan.start - last_end_).seconds() > length_s / 2 ? 1 : 0;
  last_end_ = scan.end();
  ++report_.scans;
}

std::vector<std::shared_ptr<const LidarScan>> MotionSource::add(std::shared_ptr<const LidarScan> scan) {
  if (odometry_) count(*scan, odometry_->process(scan));
  waiting_.push_back(std::move(scan));
  if (odometry_ && !odometry_->started() && waiting_.size() < kMostWaiting) return {};
  return flush();
}

std::vector<std::shared_ptr<const LidarScan>> MotionSource::flush() { return std::exchange(waiting_, {}); }

void MotionSource::leave_out(const Detection& detection) {
  if (odometry_) odometry_->remove_dynamic_points(*detection.scan, detection.object);
}

std::string MotionSource::trouble() const {
  std::vector<std::string> parts;
  const OdometryReport& r = report_;
  if (r.extrapolated > 0) {
    parts.push_back(fmt::format(
        "{} of {} scans could not be registered, the first of them scan {} of the run: their motion is "
        "extrapolated, the map was begun anew {} times",
        r.extrapolated, r.scans, r.first_extrapolated, r.restarts));
  }
  if (r.gaps > 0) parts.push_back(fmt::format("scans are missing at {} places", r.gaps));
  if (r.degenerate > 0)
    parts.push_back(
        fmt::format("in {} scans the points do not hold every direction of motion", r.degenerate));
  if (r.not_converged > 0) parts.push_back(fmt::format("{} scans did not converge", r.not_converged));
  if (r.ambiguous_start)
    parts.emplace_back(
        "the speed at the start is uncertain: another motion explains the first scans as well");
  return parts.empty() ? "" : fmt::format("odometry: {}", fmt::join(parts, "; "));
}

}  // namespace mapless::app
