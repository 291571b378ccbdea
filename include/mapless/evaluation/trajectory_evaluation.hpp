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

/// The value below which a fraction `q` in [0, 1] of `values` lies, linear between the two nearest ranks (the
/// median of an even count is the mean of the middle two). Absent for no values.
[[nodiscard]] std::optional<double> quantile(std::vector<double> values, double q);

/// One instant of a true and of an estimated trajectory, each in a world frame of its own.
struct PosePair {
  std::size_t scan = 0;  ///< of the recording, from 0; one pair a scan, by increasing scan
  Time time;
  SE3 T_0v_true;
  SE3 T_0v_estimated;
};

/// A list of errors, all at least 0, in few figures. p95 as quantile().
struct ErrorFigures {
  std::size_t count = 0;
  double rmse = 0, mean = 0, median = 0, p95 = 0, max = 0;
};

/// Absent for no errors.
[[nodiscard]] std::optional<ErrorFigures> figures_of(const std::vector<double>& errors);

/// Lengths of the translation [m] and angles of the rotation [deg] of a list of pose errors.
struct PoseErrors {
  ErrorFigures translation_m;
  ErrorFigures rotation_deg;
};

/// Mean over the segments of one length.
struct DriftOfLength {
  double length_m = 0;
  std::size_t segments = 0;
  double translation_percent = 0;
  double rotation_deg_per_100m = 0;
};

struct Drift {
  std::vector<DriftOfLength> by_length;  ///< those of which there is a segment
  std::size_t segments = 0;
  double translation_percent = 0;  ///< mean over all segments of all lengths
  double rotation_deg_per_100m = 0;
};

/// Error growth as KITTI's odometry benchmark counts it (Geiger et al., CVPR 2012; its devkit). A segment
/// begins at every tenth pose and ends at the first pose whose way along the true poses is longer by L, for
/// each L = 100, 200 ... 800 m. Its error is E = (E_1^-1 E_2)^-1 (T_1^-1 T_2), E estimated and T true poses:
/// |translation| / L and angle / L. A drive of less than 200 m has shorter segments: L = u, 2u ... 8u with u
/// the longest of 50, 20, 10, 5, 2 and 1 m of which it is twice as long, begun at every pose. Absent where
/// there is no segment.
[[nodiscard]] std::optional<Drift> drift(std::span<const PosePair> pairs);

/// Way along the true poses [m].
[[nodiscard]] double path_length_m(std::span<const PosePair> pairs);

/// ATE: distances between true and estimated positions, the estimated trajectory moved as a whole (rotation
/// and translation, no scale) to where their sum of squares is least (Umeyama, PAMI 1991). "evo_ape tum
/// --align" gives the same. Absent for fewer than three pairs.
[[nodiscard]] std::optional<ErrorFigures> absolute_error_aligned(std::span<const PosePair> pairs);

/// The same where the first poses are laid upon each other: translation and angle of T_k^-1 E_k. "evo_ape tum
/// --align_origin" gives the same. The first pair itself does count. Absent for fewer than two pairs.
[[nodiscard]] std::optional<PoseErrors> absolute_error_from_first(std::span<const PosePair> pairs);

/// RPE over one scan: translation and angle of (T_k^-1 T_k+1)^-1 (E_k^-1 E_k+1), for every two pairs of
/// consecutive scans, the first of which is `first_scan` or later. "evo_rpe tum --delta 1 --delta_unit f"
/// gives the same where no scan is missing. Absent where there are none.
[[nodiscard]] std::optional<PoseErrors> relative_error_per_scan(std::span<const PosePair> pairs,
                                                                std::size_t first_scan = 0);

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
