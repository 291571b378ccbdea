#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include <mapless/core/se3.hpp>
#include <mapless/core/time.hpp>
#include <mapless/io/dataset.hpp>
#include <mapless/trajectory/trajectory.hpp>

namespace mapless::inline v1 {

/// The quantile `q` of the values, interpolated linearly between the two nearest ranks (the median of an even
/// count is the mean of the middle two). Absent for no values. Throws ParameterError for q outside [0, 1].
[[nodiscard]] std::optional<double> quantile(std::vector<double> values, double q);

/// True and estimated pose at one instant, each with respect to its own world frame.
struct PosePair {
  std::size_t scan = 0;  ///< number in the recording, from 0; pairs are sorted by it, at most one per scan
  Time time;
  SE3 T_0v_true;
  SE3 T_0v_estimated;
};

/// Statistics of a list of errors that are at least 0. median and p95 as quantile() defines them.
struct ErrorFigures {
  std::size_t count = 0;
  double rmse = 0, mean = 0, median = 0, p95 = 0, max = 0;
};

/// The statistics of `errors`; absent for none.
[[nodiscard]] std::optional<ErrorFigures> figures_of(const std::vector<double>& errors);

/// Statistics of a list of pose errors: length of the translation [m], angle of the rotation [deg].
struct PoseErrors {
  ErrorFigures translation_m;
  ErrorFigures rotation_deg;
};

/// Mean error over the segments of one length.
struct DriftOfLength {
  double length_m = 0;
  std::size_t segments = 0;
  double translation_percent = 0;
  double rotation_deg_per_100m = 0;
};

struct Drift {
  std::vector<DriftOfLength> by_length;  ///< the lengths with at least one segment
  std::size_t segments = 0;
  double translation_percent = 0;  ///< mean over all segments of all lengths
  double rotation_deg_per_100m = 0;
};

/// Drift as the KITTI odometry benchmark defines it (Geiger et al., CVPR 2012; its devkit). A segment starts
/// at every tenth pose and ends at the first pose at a distance of more than L along the true poses, for L =
/// 100, 200 ... 800 m. Its error is (E_1^-1 E_2)^-1 (T_1^-1 T_2), with estimated poses E and true poses T:
/// |translation| / L and angle / L. A drive of less than 200 m has shorter segments, from every pose: L = u,
/// 2u ... 8u, where u is the largest of 50, 20, 10, 5, 2 and 1 m that fits twice into the drive. Absent if
/// there is no segment. Throws ParameterError if the pairs are not sorted by scan.
[[nodiscard]] std::optional<Drift> drift(std::span<const PosePair> pairs);

/// Length of the path along the true poses [m].
[[nodiscard]] double path_length_m(std::span<const PosePair> pairs);

/// Absolute trajectory error: distances between true and estimated positions after the rigid transform of the
/// whole estimated trajectory that minimises the sum of their squares (Umeyama, PAMI 1991). Agrees with
/// "evo_ape tum --align". Absent for fewer than three pairs.
[[nodiscard]] std::optional<ErrorFigures> absolute_error_aligned(std::span<const PosePair> pairs);

/// Absolute trajectory error after alignment of the first poses: translation and angle of T_k^-1 E_k, first
/// pair included. Agrees with "evo_ape tum --align_origin". Absent for fewer than two pairs.
[[nodiscard]] std::optional<PoseErrors> absolute_error_from_first(std::span<const PosePair> pairs);

/// Relative pose error over one scan: translation and angle of (T_k^-1 T_k+1)^-1 (E_k^-1 E_k+1) for every
/// pair of consecutive scans from `first_scan` on. Agrees with "evo_rpe tum --delta 1 --delta_unit f" if no
/// scan is missing. Absent if there is no such pair.
[[nodiscard]] std::optional<PoseErrors> relative_error_per_scan(std::span<const PosePair> pairs,
                                                                std::size_t first_scan = 0);

/// Displacements are measured over this many scans, 0.4 s at 10 Hz: the scan gap of the published method.
inline constexpr std::size_t kDisplacementGap = 4;
/// "Settled" statistics leave out the scans before this one, in which the odometry starts up.
inline constexpr std::size_t kSettledFrom = 10;
/// Displacements are measured at every such return. Chosen: prime, so that every laser and column
/// contributes; about 4000 returns a scan.
inline constexpr std::size_t kDisplacementStride = 17;

/// Lengths of the differences between estimated and true mean velocity from each pose of the estimate to the
/// next, ln(T_v0(t_2) T_v0(t_1)^-1) / (t_2 - t_1).
struct VelocityError {
  ErrorFigures linear_m_per_s;
  ErrorFigures angular_deg_per_s;
};

/// Apparent displacement of static points over kDisplacementGap scans that the estimated trajectory alone
/// causes.
struct DisplacementError {
  ErrorFigures distance_m;  ///< of every kDisplacementStride-th return
  std::size_t scans = 0;
};

/// An estimated trajectory compared with the true one. Compared are the poses of the estimate, the first in
/// each scan (from 5 % of its duration before its start on), with the interpolated truth: poses at the start,
/// the middle or the end of the scans are all compared at their own instants. A member is absent if there are
/// too few poses.
struct TrajectoryReport {
  std::size_t rows = 0;   ///< number of poses of the estimate
  std::size_t poses = 0;  ///< number of poses that are compared
  std::size_t scans = 0;  ///< number of scans of the recording
  double path_length_m = 0;
  std::optional<Drift> drift;
  std::optional<ErrorFigures> absolute_aligned_m;
  std::optional<PoseErrors> absolute_from_first;
  std::optional<PoseErrors> relative_per_scan;
  std::optional<PoseErrors> relative_per_scan_settled;  ///< from scan kSettledFrom on
  std::optional<VelocityError> velocity;
  std::optional<DisplacementError> displacement;
  std::optional<DisplacementError> displacement_settled;  ///< both scans from kSettledFrom on
};

/// Compares `estimate` with `truth`. Velocity and displacement leave out gaps of more than 1.5 scans between
/// two poses of the estimate. It is interpolated at constant velocity, so that several poses a scan also
/// describe the motion within the scan. Throws InputError if no pose of the estimate lies within a scan of
/// the recording and the time of the truth.
[[nodiscard]] TrajectoryReport evaluate_trajectory(
    const Dataset& dataset, const Trajectory& truth, const SampledTrajectory& estimate,
    const std::function<void(std::size_t done, std::size_t of)>& progress = {});

/// The pairs of poses that evaluate_trajectory compares.
[[nodiscard]] std::vector<PosePair> pair_poses(const Dataset& dataset, const Trajectory& truth,
                                               const SampledTrajectory& estimate);

}  // namespace mapless
