#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include <mapless/lidar/lidar_scan.hpp>
#include <mapless/simulation/world.hpp>
#include <mapless/trajectory/trajectory.hpp>

namespace mapless::inline v1 {

/// Truth counts a surface as dynamic above this speed (paper, section on its benchmark) [m/s].
inline constexpr double kDynamicSpeed = 0.2;

struct SensorOptions {
  double range_noise_m = 0.02;  ///< standard deviation, Gaussian
  bool faulty = true;           ///< whether dark, glassy and grazed surfaces may give no return
  std::uint64_t seed = 1;
};

/// One turn. One entry per firing, laser by laser, then column.
struct SimulatedScan {
  Time start;
  std::vector<LidarRecord> records;
  std::vector<std::uint32_t> labels;  ///< as io/labels.hpp, high 16 bits the object's id; 0 without a return
  std::vector<float> intensities;     ///< 0 to 1
};

/// A lidar that is moved along a trajectory through a world. Every ray starts at its laser's own pose at its
/// own firing time. Noise and faults depend on seed, scan, laser and column alone.
class SimulatedSensor {
 public:
  /// The world is prepared by scan(); nobody else may do so meanwhile.
  SimulatedSensor(std::shared_ptr<const LidarModel> model, std::shared_ptr<const Trajectory> trajectory,
                  SimulatedWorld& world, SensorOptions options);

  /// Scan `number`, which starts at number / rotation rate after the trajectory's epoch (time 0). Throws
  /// TrajectoryDomainError where the trajectory does not reach.
  [[nodiscard]] SimulatedScan scan(int number);
  /// The same as odometry and detection want it, without its truth.
  [[nodiscard]] std::shared_ptr<const LidarScan> lidar_scan(int number);

 private:
  void cast_column(int number, int column, SimulatedScan& out) const;
  void finish_record(int number, int laser, int column, const Eigen::Matrix3d& C_vh,
                     const std::optional<RayHit>& hit, SimulatedScan& out) const;
  [[nodiscard]] double fault_probability(const RayHit& hit) const;
  [[nodiscard]] Time firing_time(Time start, int column, int laser) const;

  std::shared_ptr<const LidarModel> model_;
  std::shared_ptr<const Trajectory> trajectory_;
  SimulatedWorld& world_;
  SensorOptions options_;
  std::vector<Eigen::Vector3d> directions_h_;  // of the lasers
  Duration column_period_;
  Duration first_firing_, last_firing_;  // of a column's lasers, from the column's instant
};

}  // namespace mapless
