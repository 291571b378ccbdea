#pragma once

#include <cstdint>
#include <memory>
#include <string_view>
#include <vector>

#include "support/toy_world.hpp"
#include <mapless/lidar/lidar_scan.hpp>
#include <mapless/trajectory/trajectory.hpp>

namespace mapless::test {

/// A sensor that keeps its body-centric velocity for ever: T_v0(t) = exp(t varpi^) T_v0(0). Straight lines,
/// arcs, turns on the spot and screws are all of this kind.
class SteadyTrajectory final : public Trajectory {
 public:
  /// `varpi` as in TrajectoryState: a sensor that moves with velocity v and turn rate w in its own frame has
  /// (-v, -w).
  SteadyTrajectory(const SE3& T_v0_at_zero, const Vector6d& varpi) : T_v0_(T_v0_at_zero), varpi_(varpi) {}
  [[nodiscard]] Time begin() const override;
  [[nodiscard]] Time end() const override;
  [[nodiscard]] TrajectoryState at(Time t) const override;

 private:
  SE3 T_v0_;
  Vector6d varpi_;
};

/// From the origin, x ahead: forward at `speed` [m/s], turning at `yaw_rate` [rad/s], counter-clockwise
/// positive.
[[nodiscard]] std::shared_ptr<const Trajectory> drive(double speed, double yaw_rate);

/// The same motion in a world that is named differently: T_v0(t) T_0w, delayed by `delay`.
class MovedTrajectory final : public Trajectory {
 public:
  MovedTrajectory(std::shared_ptr<const Trajectory> trajectory, const SE3& T_0w, Duration delay)
      : trajectory_(std::move(trajectory)), T_0w_(T_0w), delay_(delay) {}
  [[nodiscard]] Time begin() const override { return trajectory_->begin() + delay_; }
  [[nodiscard]] Time end() const override { return trajectory_->end() + delay_; }
  [[nodiscard]] TrajectoryState at(Time t) const override;

 private:
  std::shared_ptr<const Trajectory> trajectory_;
  SE3 T_0w_;
  Duration delay_;
};

/// A world seen by a sensor that moves through it.
struct ToyScene {
  std::shared_ptr<const LidarModel> model;
  std::shared_ptr<const Trajectory> trajectory;
  ToyWorld world;
  double range_noise_m = 0;                     ///< standard deviation
  std::uint64_t seed = 1;                       ///< of the noise
  ReturnCode empty_code = ReturnCode::nothing;  ///< code of a ray without a surface within range
};

/// One turn of the sensor, in the forms the native format and the detector want it.
struct ToyScan {
  std::vector<LidarRecord> records;       ///< laser by laser, then column
  std::vector<std::uint32_t> labels;      ///< per record: class and object, as io/labels.hpp
  std::shared_ptr<const LidarScan> scan;  ///< the records, organised
};

/// Scan `number` starts at number / rotation rate. Every ray is cast from its laser's own pose at its own
/// instant, into the world of that instant. Truth is dynamic where the surface moves faster than 0.2 m/s
/// then. The same for any number of threads.
[[nodiscard]] ToyScan cast_scan(const ToyScene& scene, int number);

/// A street with parked cars, house fronts and trees, people walking, oncoming and crossing cars; the sensor
/// drives at 8 m/s and turns left at the crossing. Lasts 6.5 s.
[[nodiscard]] ToyScene toy_street(std::string_view sensor = "HDL-64E-S2");

/// The scene as measured by a sensor with `columns` firings a turn: fewer rays where many are not needed.
[[nodiscard]] ToyScene with_columns(ToyScene scene, int columns);

/// A closed room with furniture, in which nothing moves.
[[nodiscard]] ToyScene toy_room(std::string_view sensor, std::shared_ptr<const Trajectory> trajectory);

}  // namespace mapless::test
