#include <array>

#include <fmt/format.h>

#include "simulation/random.hpp"
#include "simulation/scenes/named_scenes.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/simulation/scene.hpp>

namespace mapless::inline v1 {
namespace {

using Eigen::Vector3d;

struct NamedScene {
  std::string_view name;
  Scene (*make)(const SceneOptions&);
};

constexpr std::array<NamedScene, 9> kScenes = {{{"town1", town1},
                                                {"town2", town2},
                                                {"highway", highway},
                                                {"forest", forest},
                                                {"tunnel", tunnel},
                                                {"flyer", flyer},
                                                {"tilted", tilted},
                                                {"crossing", crossing},
                                                {"random", random_scene}}};

SE3 arbitrary_rotation(std::uint64_t seed) {
  RandomSequence random(seed, 99);
  const Vector3d axis(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
  return {so3_exp(axis.normalized() * random.uniform(0.8, 2.4)), Vector3d::Zero()};
}

}  // namespace

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

}  // namespace mapless
