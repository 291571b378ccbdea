#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "run/busy_time.hpp"
#include <mapless/lidar/lidar_scan.hpp>
#include <mapless/simulation/scene.hpp>
#include <mapless/simulation/simulated_sensor.hpp>
#include <mapless/trajectory/trajectory.hpp>

namespace mapless::app {

/// A named model, or one of OS1-64 and OS1-128 with another number of columns: OS1-128x2048. Throws
/// ParameterError.
[[nodiscard]] LidarModel sensor_of(const std::string& name);

/// A scene with a sensor in it, simulated in memory.
class SpeedDrive {
 public:
  SpeedDrive(const std::string& scene, double duration_s, std::uint64_t seed, const std::string& sensor);

  [[nodiscard]] std::shared_ptr<const LidarScan> scan(int number);
  [[nodiscard]] const Trajectory& trajectory() const { return *trajectory_; }
  [[nodiscard]] double rotation_rate_hz() const { return model_->rotation_rate_hz; }
  [[nodiscard]] std::size_t rays() const {
    return model_->lasers.size() * static_cast<std::size_t>(model_->columns);
  }

 private:
  Scene scene_;
  std::shared_ptr<const LidarModel> model_;
  std::shared_ptr<const Trajectory> trajectory_;
  SimulatedWorld world_;
  SimulatedSensor sensor_;
};

/// Time of nanoflann to build a k-d tree of one cloud and to find the nearest of its points to every point of
/// the other.
[[nodiscard]] BusyTime yardstick(const std::vector<Eigen::Vector3d>& of,
                                 const std::vector<Eigen::Vector3d>& queries);

}  // namespace mapless::app
