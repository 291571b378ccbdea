#include <algorithm>
#include <map>
#include <numbers>

#include <fmt/format.h>

#include "evaluation/static_displacement.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/evaluation/trajectory_evaluation.hpp>

namespace mapless::inline v1 {
namespace {

// A gap of two scans and more is a missing pose; one of up to 1.5 is jitter of the times.
constexpr double kWidestGapInScans = 1.5;
// A pose at the end of a scan counts as one at the start of the next; their times may differ in the last
// digits.
constexpr double kEarlyInScans = 0.05;

bool covers(const Trajectory& trajectory, Time begin, Time end) {
  return trajectory.begin() <= begin && end <= trajectory.end();
}

Duration scan_length(const Dataset& dataset, std::size_t k) {
  return dataset.scan_end(k) - dataset.scan_start(k);
}

// The estimate is not interpolated between poses farther apart than this.
Duration widest_gap(const Dataset& dataset) { return scan_length(dataset, 0) * kWidestGapInScans; }

Time last_column(const Dataset& dataset, std::size_t k) {
  const int columns = std::max(1, dataset.model()->columns);
  return dataset.scan_end(k) - Duration::from_nanoseconds(scan_length(dataset, k).nanoseconds() / columns);
}

bool has_gap(const std::vector<TimedPose>& rows, Time begin, Time end, Duration widest) {
  for (std::size_t i = 0; i + 1 < rows.size(); ++i) {
    if (rows[i + 1].time > begin && rows[i].time < end && rows[i + 1].time - rows[i].time > widest)
      return true;
  }
  return false;
}

bool usable(const Dataset& dataset, const Trajectory& truth, const SampledTrajectory& estimate,
            std::size_t k) {
  const Time begin = dataset.scan_start(k);
  const Time end = last_column(dataset, k);
  return covers(truth, begin, end) && covers(estimate, begin, end) &&
         !has_gap(estimate.poses(), begin, end, widest_gap(dataset));
}

std::optional<VelocityError> velocity_error(const Dataset& dataset, const Trajectory& truth,
                                            const SampledTrajectory& estimate) {
  std::vector<double> linear, angular;
  const auto& rows = estimate.poses();
  for (std::size_t i = 0; i + 1 < rows.size(); ++i) {
    const Time from = rows[i].time;
    const Time to = rows[i + 1].time;
    if (to - from > widest_gap(dataset) || !covers(truth, from, to)) continue;
    const Vector6d estimated = (rows[i + 1].T_v0 * rows[i].T_v0.inverse()).log();
    const Vector6d real = (truth.at(to).T_v0 * truth.at(from).T_v0.inverse()).log();
    const Vector6d error = (estimated - real) / (to - from).seconds();
    linear.push_back(error.head<3>().norm());
    angular.push_back(error.tail<3>().norm() * 180 / std::numbers::pi);
  }
  if (linear.empty()) return std::nullopt;
  return VelocityError{*figures_of(linear), *figures_of(angular)};
}

struct Displacements {
  std::vector<double> distances;
  std::size_t scans = 0;

  void add(const std::vector<double>& of_scan) {
    distances.insert(distances.end(), of_scan.begin(), of_scan.end());
    ++scans;
  }
  [[nodiscard]] std::optional<DisplacementError> error() const {
    if (distances.empty()) return std::nullopt;
    return DisplacementError{*figures_of(distances), scans};
  }
};

void add_displacements(const Dataset& dataset, const Trajectory& truth, const SampledTrajectory& estimate,
                       const std::function<void(std::size_t, std::size_t)>& progress,
                       TrajectoryReport& report) {
  std::map<std::size_t, ScanPoses> recent;
  Displacements all, settled;
  for (std::size_t k = 0; k < dataset.size(); ++k) {
    if (usable(dataset, truth, estimate, k)) {
      const LidarScan scan = dataset.read(k);
      const ScanPoses& here = recent.emplace(k, poses_of(scan, truth, estimate)).first->second;
      const auto before = k < kDisplacementGap ? recent.end() : recent.find(k - kDisplacementGap);
      if (before != recent.end()) {
        const auto distances = static_displacements(scan, here, before->second, kDisplacementStride);
        all.add(distances);
        if (k >= kSettledFrom + kDisplacementGap) settled.add(distances);
      }
    }
    if (k >= kDisplacementGap) recent.erase(k - kDisplacementGap);
    if (progress) progress(k + 1, dataset.size());
  }
  report.displacement = all.error();
  report.displacement_settled = settled.error();
}

}  // namespace

std::vector<PosePair> pair_poses(const Dataset& dataset, const Trajectory& truth,
                                 const SampledTrajectory& estimate) {
  std::vector<PosePair> pairs;
  auto row = estimate.poses().begin();
  const auto end = estimate.poses().end();
  for (std::size_t k = 0; k < dataset.size(); ++k) {
    const bool last = k + 1 == dataset.size();
    const Duration early = scan_length(dataset, k) * kEarlyInScans;
    const Time scan_end = (last ? dataset.scan_end(k) : dataset.scan_start(k + 1)) - early;
    while (row != end && row->time < dataset.scan_start(k) - early) ++row;
    if (row == end) break;
    if (row->time >= scan_end || !covers(truth, row->time, row->time)) continue;
    pairs.push_back({k, row->time, truth.at(row->time).T_v0.inverse(), row->T_v0.inverse()});
  }
  return pairs;
}

TrajectoryReport evaluate_trajectory(const Dataset& dataset, const Trajectory& truth,
                                     const SampledTrajectory& estimate,
                                     const std::function<void(std::size_t, std::size_t)>& progress) {
  const std::vector<PosePair> pairs = pair_poses(dataset, truth, estimate);
  if (pairs.empty()) {
    throw InputError({"trajectory", "times",
                      fmt::format("{:.6f} to {:.6f} s", estimate.poses().front().time.seconds(),
                                  estimate.poses().back().time.seconds()),
                      fmt::format("no pose within a scan and the true trajectory, {:.6f} to {:.6f} s",
                                  truth.begin().seconds(), truth.end().seconds()),
                      "give a trajectory of this recording, its times in the recording's clock"});
  }
  TrajectoryReport report;
  report.rows = estimate.poses().size();
  report.poses = pairs.size();
  report.scans = dataset.size();
  report.path_length_m = path_length_m(pairs);
  report.drift = drift(pairs);
  report.absolute_aligned_m = absolute_error_aligned(pairs);
  report.absolute_from_first = absolute_error_from_first(pairs);
  report.relative_per_scan = relative_error_per_scan(pairs);
  report.relative_per_scan_settled = relative_error_per_scan(pairs, kSettledFrom);
  report.velocity = velocity_error(dataset, truth, estimate);
  add_displacements(dataset, truth, estimate, progress, report);
  return report;
}

}  // namespace mapless
