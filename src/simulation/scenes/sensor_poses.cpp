#include "simulation/scenes/sensor_poses.hpp"

#include <cmath>
#include <cstdint>
#include <numbers>

namespace mapless::inline v1 {

using Eigen::Vector3d;

std::vector<TimedPose> sample_poses(const std::function<SE3(double t_s)>& T_0v, double duration_s) {
  constexpr std::int64_t kStep_ns = 5'000'000;  // 200 Hz
  const auto last = static_cast<std::int64_t>(std::ceil((duration_s + 0.1) * 1e9 / kStep_ns));
  std::vector<TimedPose> poses;
  for (std::int64_t k = -20; k <= last; ++k) {
    const Time t = Time::from_nanoseconds(k * kStep_ns);
    poses.push_back({t, T_0v(t.seconds()).inverse()});
  }
  return poses;
}

SE3 ridden(const Track& track, double t_s) {
  constexpr double kLag_s = 0.4;  // over which the suspension averages the acceleration
  const double acceleration = (track.speed(t_s + kLag_s) - track.speed(t_s - kLag_s)) / (2 * kLag_s);
  const double s = track.distance_m(t_s);
  const auto before = track.path().heading(s - 2, 4);
  const auto after = track.path().heading(s + 2, 4);
  const double curvature = (before.x() * after.y() - before.y() * after.x()) / 4;
  const double v = track.speed(t_s);
  const double pitch = -0.009 * acceleration + 0.0012 * v / (1 + v) * std::sin(7.5 * t_s);
  const double roll = 0.008 * curvature * v * v + 0.0015 * v / (1 + v) * std::sin(5.1 * t_s + 1);
  const Vector3d bounce(0, 0, 0.012 * v / (2 + v) * std::sin(8.3 * t_s));
  return track.pose(t_s) * SE3(so3_exp({roll, pitch, 0}), bounce);
}

std::vector<TimedPose> ride(const Track& track, const SE3& T_bv, double duration_s) {
  return sample_poses([&](double t) { return ridden(track, t) * T_bv; }, duration_s);
}

SE3 carried(const Track& track, double height_m, double t_s) {
  const double steps = 2 * std::numbers::pi * track.distance_m(t_s) / 0.7;
  const SE3 sway(
      so3_exp({0.04 * std::sin(steps / 2), 0.03 * std::sin(steps), 0.06 * std::sin(steps / 2 + 0.7)}),
      {0, 0.03 * std::sin(steps / 2), height_m + 0.03 * std::sin(steps)});
  return track.pose(t_s) * sway;
}

SE3 hand_held(const Track& track, double shake, double t_s) {
  const double steps = 2 * std::numbers::pi * track.distance_m(t_s) / 0.7;
  const Vector3d turned(0.25 * std::sin(1.9 * t_s) + 0.03 * std::sin(steps), 0.22 * std::sin(2.6 * t_s + 1),
                        0.9 * std::sin(1.3 * t_s) + 0.35 * std::sin(3.1 * t_s));
  const SE3 hand(so3_exp(shake * turned),
                 {0.3, -0.1 + 0.05 * std::sin(steps / 2), 1.45 + 0.04 * std::sin(steps)});
  return track.pose(t_s) * hand;
}

}  // namespace mapless
