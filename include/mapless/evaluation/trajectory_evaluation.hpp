#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

#include <mapless/evaluation/trajectory_error.hpp>
#include <mapless/io/dataset.hpp>
#include <mapless/trajectory/trajectory.hpp>

namespace mapless::inline v1 {

/// Scans between the two that a displacement is between, and those the "settled" figures leave out.
inline constexpr std::size_t kDisplacementGap = 4;
inline constexpr std::size_t kSettledFrom = 10;
/// Every such return of a scan counts for the displacement.
inline constexpr std::size_t kDisplacementStride = 17;

/// Mean velocity from each pose of the estimate to the next, ln(T_v0(t_2) T_v0(t_1)^-1) / (t_2 - t_1),
/// against that of the truth over the same time: lengths of the differences.
struct VelocityError {
  ErrorFigures linear_m_per_s;
  ErrorFigures angular_deg_per_s;
};

/// static_displacements over kDisplacementGap scans.
struct DisplacementError {
  ErrorFigures distance_m;  ///< of every kDisplacementStride-th return
  std::size_t scans = 0;
};

/// How well an estimated trajectory agrees with the true one. Poses are compared at the estimate's own poses,
/// the first in each scan (from 5 % before its start on), with the truth interpolated; so poses at the
/// starts, middles or ends of the scans are all compared as they were meant. What is absent had too few
/// poses.
struct TrajectoryReport {
  std::size_t rows = 0;   ///< poses of the estimate
  std::size_t poses = 0;  ///< scans with a pose within the time of the true trajectory: those compared
  std::size_t scans = 0;  ///< of the recording
  double path_length_m = 0;
  std::optional<Drift> drift;
  std::optional<ErrorFigures> absolute_aligned_m;
  std::optional<PoseErrors> absolute_from_first;
  std::optional<PoseErrors> relative_per_scan;
  std::optional<PoseErrors> relative_per_scan_settled;  ///< from scan kSettledFrom on
  std::optional<VelocityError> velocity;
  std::optional<DisplacementError> displacement;
  std::optional<DisplacementError> displacement_settled;  ///< both scans kSettledFrom or later
};

/// Velocity and displacement leave out where the estimate's poses are more than 1.5 scans apart; between the
/// others it is interpolated at constant velocity, so a result with several poses a scan is judged by its
/// motion within the scan too. Throws InputError where no pose of the estimate falls into a scan of the
/// recording and the time of the truth.
[[nodiscard]] TrajectoryReport evaluate_trajectory(
    const Dataset& dataset, const Trajectory& truth, const SampledTrajectory& estimate,
    const std::function<void(std::size_t done, std::size_t of)>& progress = {});

/// The pairs that evaluate_trajectory compares.
[[nodiscard]] std::vector<PosePair> pair_poses(const Dataset& dataset, const Trajectory& truth,
                                               const SampledTrajectory& estimate);

}  // namespace mapless
