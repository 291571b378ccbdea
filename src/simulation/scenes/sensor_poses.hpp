#pragma once

#include <functional>
#include <vector>

#include "simulation/traffic/path.hpp"
#include <mapless/trajectory/trajectory.hpp>

namespace mapless::inline v1 {

/// Tracks are simulated this much beyond the duration of a scene: ride() looks 0.4 s ahead, poses reach 0.1 s
/// beyond.
inline constexpr double kMargin_s = 2;

/// Samples T_0v(t) at 200 Hz from 0.1 s before time 0 to 0.1 s after `duration_s`.
[[nodiscard]] std::vector<TimedPose> sample_poses(const std::function<SE3(double t_s)>& T_0v,
                                                  double duration_s);
/// Pose T_0b at time t_s of a vehicle that follows the track; it pitches when it brakes and rolls in bends.
[[nodiscard]] SE3 ridden(const Track& track, double t_s);
/// Poses of a sensor mounted at `T_bv` on such a vehicle.
[[nodiscard]] std::vector<TimedPose> ride(const Track& track, const SE3& T_bv, double duration_s);

/// Pose T_0v at time t_s of a sensor carried on a walker's back, `height_m` above the track; it sways with
/// every step.
[[nodiscard]] SE3 carried(const Track& track, double height_m, double t_s);
/// Pose T_0v at time t_s of a sensor in the hand of a walker, turned by up to 135 degrees a second at `shake`
/// = 1.
[[nodiscard]] SE3 hand_held(const Track& track, double shake, double t_s);

}  // namespace mapless
