#include "run/odometry_run.hpp"

#include <algorithm>
#include <chrono>
#include <ctime>
#include <utility>

#include "run/lost_motion.hpp"
#include "run/scan_poses.hpp"
#include "terminal/interrupt.hpp"
#include <mapless/core/errors.hpp>

namespace mapless::app {
namespace {

// Scans that a kill may lose beside the open ones, so that estimating seldom waits for the disk.
constexpr std::size_t kMostUnwrittenRows = 4;

// The motion is kept from this long before the oldest scan whose poses are not written yet. Chosen: more than
// the times between scans, so that the knot before it stays.
const Duration kMotionKept = Duration::from_seconds(1);

Time instant_of(const LidarScan& scan, const std::string& instant) {
  if (instant == "start") return scan.start;
  if (instant == "end") return scan.end();
  return scan.start + Duration::from_nanoseconds((scan.end() - scan.start).nanoseconds() / 2);
}

Json odometry_times_json(const DurationHistogram& durations) {
  const auto ms = [&](double q) { return 1e3 * durations.quantile(q).value_or(0); };
  return {{"median", ms(0.5)}, {"p95", ms(0.95)}};
}

}  // namespace

OdometryRun::OdometryRun(const Dataset& dataset, const ResultFolder& result,
                         const OdometryParameters& parameters, PoseChoice choice,
                         std::function<void()> make_folder, std::size_t finished_before)
    : dataset_(dataset),
      result_(result),
      choice_(std::move(choice)),
      make_folder_(std::move(make_folder)),
      finished_before_(finished_before),
      odometry_(parameters),
      progress_("scans"),
      writer_(kMostUnwrittenRows, [this](const std::unique_ptr<const TableRows>& rows) { write(*rows); }) {}

bool OdometryRun::run() {
  bool complete = false;
  try {
    complete = process_all();
    while (complete && !open_.empty()) write_front();
    writer_.finish();
  } catch (...) {
    writer_.join();
    progress_.clear();
    try {
      finish(false);
    } catch (const OutputError&) {  // the first error is the one to report
    }
    throw;
  }
  finish(complete);
  progress_.clear();
  return complete;
}

bool OdometryRun::process_all() {
  for (std::size_t k = 0; k < dataset_.size(); ++k) {
    if (InterruptGuard::requested()) return false;
    process(k);
    write_settled();
    progress_.update(k + 1, dataset_.size());
  }
  return true;
}

void OdometryRun::process(std::size_t k) {
  const auto scan = std::make_shared<const LidarScan>(dataset_.read(k));
  watch_.add(*scan, k);
  const auto begin = std::chrono::steady_clock::now();
  const std::clock_t processor_begin = std::clock();
  OdometryUpdate update = odometry_.process(scan);
  durations_.add(std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
  processor_times_.add(static_cast<double>(std::clock() - processor_begin) / CLOCKS_PER_SEC);
  report_.add(*scan, update);
  update.knots.clear();  // the trajectory has them
  const MotionState state = update.state;
  // The states of the first scans are known with the scan that decides their motion.
  const std::size_t decided = std::min(update.decided_scans, open_.size() + 1);
  open_.push_back(
      {k, scan->start, instant_of(*scan, choice_.instant), scan->end() - scan->start, std::move(update)});
  for (auto one = open_.end() - static_cast<std::ptrdiff_t>(decided); one != open_.end(); ++one)
    one->update.state = state;
}

// Until started, and after a restart, later scans correct all of the start-up, of kMostStartUpScans at most.
void OdometryRun::write_settled() {
  const std::size_t open = kOpenScans + (odometry_.started() ? 0 : kMostStartUpScans);
  while (open_.size() > open) write_front();
  odometry_.forget_before(open_.front().start - kMotionKept);
}

void OdometryRun::write_front() {
  const OpenScan& scan = open_.front();
  const Trajectory& trajectory = odometry_.trajectory();
  auto rows = std::make_unique<TableRows>();
  rows->poses = scan_poses(trajectory, scan.instant, scan.instant + scan.length, choice_.per_scan);
  rows->motion = motion_row(scan.k, rows->poses.front(), scan.length.seconds(), scan.update);
  open_.pop_front();
  writer_.add(std::move(rows));
}

void OdometryRun::write(const TableRows& rows) {
  if (!tables_) {
    if (finished_before_ == 0) make_folder_();
    tables_.emplace(result_, TableChoice{false, true},
                    finished_before_ > 0 ? GrowingFile::Start::resumed : GrowingFile::Start::anew);
  }
  scans_written_ < finished_before_ ? tables_->verify(rows) : tables_->add(rows);
  ++scans_written_;
  last_pose_ = rows.poses.back().time;
}

// Poses that are still open are not written: a run that goes on would find others.
void OdometryRun::finish(bool complete) {
  if (!tables_ || scans_written_ < finished_before_) return;
  const bool to_the_end = complete && choice_.per_scan > 1;
  tables_->finish(odometry_.trajectory(), to_the_end ? odometry_.trajectory().end() : last_pose_);
}

Json OdometryRun::json() const {
  return {{"scans", scans_written_},
          {"poses", tables_ ? tables_->poses() : 0},
          {"scan_ms", odometry_times_json(durations_)},
          {"scan_cpu_ms", odometry_times_json(processor_times_)}};
}

double OdometryRun::median_ms() const { return 1e3 * durations_.quantile(0.5).value_or(0); }

}  // namespace mapless::app
