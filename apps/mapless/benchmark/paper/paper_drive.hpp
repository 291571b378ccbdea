#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "benchmark/paper/paper_plan.hpp"
#include <mapless/io/labels.hpp>
#include <mapless/lidar/lidar_scan.hpp>
#include <mapless/simulation/scene.hpp>
#include <mapless/simulation/simulated_sensor.hpp>
#include <mapless/trajectory/trajectory.hpp>

namespace mapless::app {

/// A scan with the true label of each of its records.
struct TrueScan {
  std::shared_ptr<const LidarScan> scan;
  std::vector<std::uint32_t> truth;
};

/// The drive of a unit, simulated in memory. Any scan can be made in any order.
class PaperDrive {
 public:
  explicit PaperDrive(const PaperUnit& unit);

  [[nodiscard]] TrueScan scan(std::size_t number);
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
