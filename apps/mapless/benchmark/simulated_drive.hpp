#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <mapless/io/labels.hpp>
#include <mapless/lidar/lidar_scan.hpp>
#include <mapless/simulation/scene.hpp>
#include <mapless/trajectory/trajectory.hpp>

namespace mapless::app {

/// A scan with the true label of each of its records.
struct TrueScan {
  std::shared_ptr<const LidarScan> scan;
  std::vector<std::uint32_t> truth;
};

/// A scene with a sensor in it, simulated in memory. Any scan can be made in any order.
class SimulatedDrive {
 public:
  /// Throws as make_scene and SimulatedSensor do.
  SimulatedDrive(const std::string& scene, const SceneOptions& scene_options, const LidarModel& model,
                 const SensorOptions& sensor_options);

  [[nodiscard]] TrueScan scan(int number);
  [[nodiscard]] const LidarModel& model() const { return *model_; }
  [[nodiscard]] const std::shared_ptr<const Trajectory>& trajectory() const { return trajectory_; }
  /// Classes of the movers, without states.
  [[nodiscard]] ObjectTruth objects() const;

 private:
  Scene scene_;
  std::shared_ptr<const LidarModel> model_;
  std::shared_ptr<const Trajectory> trajectory_;
  SimulatedWorld world_;
  SimulatedSensor sensor_;
};

}  // namespace mapless::app
