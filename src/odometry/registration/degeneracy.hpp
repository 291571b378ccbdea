#pragma once

#include "odometry/registration/time_bins.hpp"

namespace mapless::inline v1 {

/// Analyses how well the inliers of a scan constrain each direction of translation of the whole scan. `T_v0`
/// is the pose at the scan's end. A direction is unconstrained if its constraint ratio is below `min_ratio`
/// plus 1.5 times the ratio that the noise of the plane normals produces by itself (method.md section 6,
/// "Degeneracy").
[[nodiscard]] Degeneracy find_degeneracy(const std::vector<BinSums>& sums, const SE3& T_v0, double min_ratio);

/// Projects the unconstrained directions out of the sums of every bin: a translation of the whole scan along
/// them, with the rotation that follows it, then has no cost, so that the motion prior alone estimates it
/// (solution remapping: Zhang, Kaess and Singh, ICRA 2016).
void project_out_unconstrained(const Degeneracy& degeneracy, const SE3& T_v0, std::vector<BinSums>& sums);

/// Whether planes hardly fix the weakest direction: the smallest constraint ratio is below .003. Measured in
/// the fifth scan: VLP-16 motorways and flights have .0003 to .0025, HDL-64E .0015 to .004; wrong motions of
/// VLP-16 .0002 to .0008.
[[nodiscard]] bool is_weak(const Degeneracy& degeneracy);

}  // namespace mapless
