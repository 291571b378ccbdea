#pragma once

#include <vector>

#include "odometry/registration/mapped_trajectory.hpp"

namespace mapless::inline v1 {

/// Whether two velocities differ by less than 0.5 m/s and 0.1 rad/s: then they are the same motion, found
/// twice.
[[nodiscard]] bool are_alike(const Vector6d& varpi_a, const Vector6d& varpi_b);

/// A constant velocity under which the edges of two scans coincide.
struct EdgeMotion {
  Vector6d varpi;
  Matrix6d information = Matrix6d::Zero();  ///< of varpi
  double agreement = 0;  ///< edge_agreement() of the second scan's edges (a sample) with the first's
};

/// Where the agreement of the best motion is below this, the right one may not be among them. Measured in 33
/// starts of sixteen lasers: of right ones .20 to .33 on motorways, .37 and more elsewhere; one wrong start
/// of a tilted sensor .155, where the right motion had .11 (docs/notebook/odometry.md, "Edges that agree
/// badly").
inline constexpr double kSureAgreement = 0.2;

/// The motions between two scans by their edges alone, the best first, no two alike (are_alike). Every pair
/// of edges, one of each scan, votes for the translation between them, at every turn rate of a grid (a Hough
/// transform). The motions with most votes are refined by point-to-point registration (Besl and McKay, PAMI
/// 1992). None if the edges are few, or agree with no
/// motion.
[[nodiscard]] std::vector<EdgeMotion> edge_motions(const UsableScan& first, const UsableScan& second);

/// The edges of a scan in the world frame.
[[nodiscard]] std::vector<Eigen::Vector3d> edges_in_world(const std::vector<ScanPoint>& edges,
                                                          Time scan_start, const TrajectoryKnot& k1,
                                                          const TrajectoryKnot& k2);

}  // namespace mapless
