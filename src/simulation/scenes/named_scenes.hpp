#pragma once

#include <functional>

#include "simulation/scenes/scenery.hpp"
#include "simulation/traffic/traffic.hpp"
#include <mapless/simulation/scene.hpp>

namespace mapless::inline v1 {

/// The tracks reach this much beyond the duration, for what looks a little ahead.
inline constexpr double kMargin_s = 2;

/// Samples T_0v(t) at 200 Hz from 0.1 s before time 0 to 0.1 s after `duration_s`.
[[nodiscard]] std::vector<TimedPose> sample_poses(const std::function<SE3(double t_s)>& T_0v,
                                                  double duration_s);
/// The sensor `T_bv` on a vehicle that follows the track, nodding as it brakes and leaning in bends.
[[nodiscard]] std::vector<TimedPose> ride(const Track& track, const SE3& T_bv, double duration_s);

/// Adds everyone of `users` from number `first` on with his track.
void add_users(SceneBuilder& scene, const std::vector<RoadUser>& users,
               const std::vector<std::shared_ptr<const Track>>& tracks, std::size_t first);

// Each fills world and poses; scene_table.cpp has their names.
[[nodiscard]] Scene town1(const SceneOptions& options);
[[nodiscard]] Scene town2(const SceneOptions& options);
[[nodiscard]] Scene tilted(const SceneOptions& options);
[[nodiscard]] Scene crossing(const SceneOptions& options);
[[nodiscard]] Scene highway(const SceneOptions& options);
[[nodiscard]] Scene forest(const SceneOptions& options);
[[nodiscard]] Scene tunnel(const SceneOptions& options);
[[nodiscard]] Scene flyer(const SceneOptions& options);

}  // namespace mapless
