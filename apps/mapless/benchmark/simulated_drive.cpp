#include "benchmark/simulated_drive.hpp"

#include <utility>

namespace mapless::app {

SimulatedDrive::SimulatedDrive(const std::string& scene, const SceneOptions& scene_options,
                               const LidarModel& model, const SensorOptions& sensor_options)
    : scene_(make_scene(scene, scene_options)),
      model_(std::make_shared<const LidarModel>(model)),
      trajectory_(std::make_shared<const SampledTrajectory>(scene_.poses, Duration(), scene)),
      world_(scene_.world),
      sensor_(model_, trajectory_, world_, sensor_options) {}

TrueScan SimulatedDrive::scan(int number) {
  SimulatedScan cast = sensor_.scan(number);
  return {sensor_.lidar_scan(cast), std::move(cast.labels)};
}

ObjectTruth SimulatedDrive::objects() const {
  ObjectTruth out;
  out.has_descriptions = true;
  for (const Mover& mover : scene_.world.movers)
    out.descriptions[static_cast<std::uint32_t>(mover.object_id)] = {
        std::string(to_string(mover.object_class)), "mover"};
  return out;
}

}  // namespace mapless::app
