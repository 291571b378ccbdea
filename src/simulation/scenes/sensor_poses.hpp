#pragma once

#include <functional>
#include <vector>

#include "simulation/traffic/path.hpp"
#include <mapless/trajectory/trajectory.hpp>

namespace mapless::inline v1 {

/// The tracks reach this much beyond the duration, for what looks a little ahead.
inline constexpr double kMargin_s = 2;

/// Samples T_0v(t) at 200 Hz from 0.1 s before time 0 to 0.1 s after `duration_s`.
[[nodiscard]] std::vector<TimedPose> sample_poses(const std::function<SE3(double t_s)>& T_0v,
                                                  double duration_s);
/// The sensor `T_bv` on a vehicle that follows the track, nodding as it brakes and leaning in bends.
[[nodiscard]] std::vector<TimedPose> ride(const Track& track, const SE3& T_bv, double duration_s);

/// A sensor `height_m` over the track on somebody's back: every step is felt.
[[nodiscard]] SE3 carried(const Track& track, double height_m, double t_s);

}  // namespace mapless
