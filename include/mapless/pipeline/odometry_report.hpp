#pragma once

#include <cstddef>
#include <string>

#include <mapless/core/time.hpp>
#include <mapless/odometry/lidar_odometry.hpp>

namespace mapless::inline v1 {

/// How lidar odometry fared over a run: counts of scans by outcome.
struct OdometryReport {
  std::size_t scans = 0;
  std::size_t extrapolated = 0;        ///< not registered: the motion prior alone gives their poses
  std::size_t first_extrapolated = 0;  ///< number of the first of them, counted from 0
  std::size_t few_points = 0;          ///< ScanOutcome::few_points
  std::size_t repeated = 0;            ///< ScanOutcome::repeated
  std::size_t lost = 0;                ///< ScanOutcome::lost or restarted
  std::size_t restarts = 0;            ///< ScanOutcome::restarted
  std::size_t gaps = 0;                ///< begin more than half a scan's duration after the scan before them
  std::size_t degenerate = 0;          ///< registered, but with a direction of motion that the prior decides
  std::size_t not_converged = 0;       ///< registered, but not converged
  bool ambiguous_start = false;        ///< a second motion fits the first scans about equally well

  /// Counts the scan that `update` is of. Scans come in the order in which odometry processed them.
  void add(const LidarScan& scan, const OdometryUpdate& update);

  /// One line that lists the problems met; empty where there were none.
  [[nodiscard]] std::string trouble() const;

 private:
  Time last_end_;  // of the scan before
};

/// What limits the motion estimate of one scan, in one line; empty where the scan was registered and
/// converged with every direction of motion constrained, or was the first.
[[nodiscard]] std::string trouble_of(const OdometryUpdate& update);

}  // namespace mapless
