#include <array>
#include <cmath>

#include <fmt/format.h>

#include "simulation/scenes/named_scenes.hpp"
#include <mapless/core/errors.hpp>

namespace mapless::inline v1 {
namespace {

using Eigen::Vector3d;

struct NamedScene {
  std::string_view name;
  Scene (*make)(const SceneOptions&);
};

constexpr std::array<NamedScene, 8> kScenes = {{{"town1", town1},
                                                {"town2", town2},
                                                {"highway", highway},
                                                {"forest", forest},
                                                {"tunnel", tunnel},
                                                {"flyer", flyer},
                                                {"tilted", tilted},
                                                {"crossing", crossing}}};

SE3 arbitrary_rotation(std::uint64_t seed) {
  RandomSequence random(seed, 99);
  const Vector3d axis(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
  return {so3_exp(axis.normalized() * random.uniform(0.8, 2.4)), Vector3d::Zero()};
}

}  // namespace

std::vector<TimedPose> Scene::poses_in_world() const {
  std::vector<TimedPose> out = poses;
  const SE3 T_0w = T_w0.inverse();
  for (TimedPose& pose : out) pose.T_v0 = pose.T_v0 * T_0w;
  return out;
}

const std::vector<std::string>& scene_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> out;
    for (const NamedScene& scene : kScenes) out.emplace_back(scene.name);
    return out;
  }();
  return names;
}

Scene make_scene(std::string_view name, const SceneOptions& options) {
  if (!(options.duration_s > 0) || options.duration_s > kMaxSceneDuration_s) {
    throw ParameterError({"scene", "duration", fmt::format("{} s", options.duration_s),
                          fmt::format("not above 0 and at most {} s", kMaxSceneDuration_s),
                          "choose another duration, or several seeds"});
  }
  for (const NamedScene& known : kScenes) {
    if (known.name != name) continue;
    Scene scene = known.make(options);
    scene.name = known.name;
    if (options.arbitrary_world) scene.T_w0 = arbitrary_rotation(options.seed);
    return scene;
  }
  throw ParameterError({"scene", "name", std::string(name), "not a scene",
                        fmt::format("choose one of {}", fmt::join(scene_names(), ", "))});
}

std::vector<TimedPose> sample_poses(const std::function<SE3(double t_s)>& T_0v, double duration_s) {
  constexpr std::int64_t kStep_ns = 5'000'000;
  const auto last = static_cast<std::int64_t>(std::ceil((duration_s + 0.1) * 1e9 / kStep_ns));
  std::vector<TimedPose> poses;
  for (std::int64_t k = -20; k <= last; ++k) {
    const Time t = Time::from_nanoseconds(k * kStep_ns);
    poses.push_back({t, T_0v(t.seconds()).inverse()});
  }
  return poses;
}

std::vector<TimedPose> ride(const Track& track, const SE3& T_bv, double duration_s) {
  const auto T_0v = [&](double t) {
    constexpr double kLag_s = 0.4;  // of the springs
    const double acceleration = (track.speed(t + kLag_s) - track.speed(t - kLag_s)) / (2 * kLag_s);
    const double s = track.distance_m(t);
    const auto before = track.path().heading(s - 2, 4);
    const auto after = track.path().heading(s + 2, 4);
    const double curvature = (before.x() * after.y() - before.y() * after.x()) / 4;
    const double v = track.speed(t);
    const double pitch = -0.009 * acceleration + 0.0012 * v / (1 + v) * std::sin(7.5 * t);
    const double roll = 0.008 * curvature * v * v + 0.0015 * v / (1 + v) * std::sin(5.1 * t + 1);
    const Vector3d bounce(0, 0, 0.012 * v / (2 + v) * std::sin(8.3 * t));
    return track.pose(t) * SE3(so3_exp({roll, pitch, 0}), bounce) * T_bv;
  };
  return sample_poses(T_0v, duration_s);
}

void add_users(SceneBuilder& scene, const std::vector<RoadUser>& users,
               const std::vector<std::shared_ptr<const Track>>& tracks, std::size_t first) {
  for (std::size_t i = first; i < users.size(); ++i) {
    const int variant = static_cast<int>(i);
    switch (users[i].object_class) {
      case ObjectClass::person:
        add_person(scene, variant, tracks[i]);
        break;
      case ObjectClass::dog:
        add_dog(scene, tracks[i]);
        break;
      case ObjectClass::cyclist:
      case ObjectClass::motorcycle:
        add_cyclist(scene, users[i].object_class, tracks[i]);
        break;
      default:
        add_vehicle(scene, users[i].object_class, variant, tracks[i]);
    }
  }
}

}  // namespace mapless
