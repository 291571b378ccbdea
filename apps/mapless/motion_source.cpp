#include "motion_source.hpp"

#include <utility>

#include <fmt/format.h>

namespace mapless::app {
namespace {

// Where no scan has points to register, detection goes on with a sensor that stands still.
constexpr std::size_t kMostWaiting = 10;

bool needs_odometry(const Dataset& dataset, const TrajectoryRequest& request, std::size_t first) {
  if (request.stationary || !request.file.empty() || dataset.trajectory() != nullptr) return false;
  // Compensated points no longer tell when they were measured; their poses are needed to undo it.
  return !dataset.read(first).compensated_to;
}

}  // namespace

MotionSource::MotionSource(const Dataset& dataset, const TrajectoryRequest& request, std::size_t first) {
  if (needs_odometry(dataset, request, first)) {
    use_odometry();
  } else {
    source_ = open_trajectory(dataset, request);
  }
}

MotionSource MotionSource::odometry() {
  MotionSource out;
  out.use_odometry();
  return out;
}

void MotionSource::use_odometry() {
  source_.conventions = {{"source", "estimated by lidar odometry"}};
  odometry_.emplace();
}

const Trajectory& MotionSource::trajectory() const {
  return odometry_ ? odometry_->trajectory() : *source_.trajectory;
}

std::vector<std::shared_ptr<const LidarScan>> MotionSource::add(std::shared_ptr<const LidarScan> scan) {
  if (odometry_) {
    const OdometryUpdate update = odometry_->process(scan);
    const bool by_prior = update.outcome != ScanOutcome::first && update.outcome != ScanOutcome::registered;
    if (by_prior && by_prior_++ == 0) first_by_prior_ = added_;
    restarts_ += update.outcome == ScanOutcome::restarted ? 1 : 0;
    degenerate_ += update.outcome == ScanOutcome::registered && update.degeneracy.held_by_prior > 0 ? 1 : 0;
  }
  ++added_;
  waiting_.push_back(std::move(scan));
  if (odometry_ && !odometry_->started() && waiting_.size() < kMostWaiting) return {};
  return flush();
}

std::vector<std::shared_ptr<const LidarScan>> MotionSource::flush() { return std::exchange(waiting_, {}); }

std::string MotionSource::trouble() const {
  std::string line;
  if (by_prior_ > 0) {
    line = fmt::format(
        "{} of {} scans could not be registered, the first of them scan {} of the run: their "
        "motion is extrapolated, the map was begun anew {} times",
        by_prior_, added_, first_by_prior_, restarts_);
  }
  if (degenerate_ > 0) {
    line += fmt::format("{}in {} scans the points do not hold every direction of motion",
                        line.empty() ? "" : "; ", degenerate_);
  }
  return line.empty() ? line : "odometry: " + line;
}

}  // namespace mapless::app
