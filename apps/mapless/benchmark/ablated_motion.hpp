#pragma once

#include <memory>

#include "benchmark/plan.hpp"
#include <mapless/lidar/lidar_scan.hpp>
#include <mapless/trajectory/trajectory.hpp>

namespace mapless::app {

/// A sensor that keeps the pose it has at one instant.
class FrozenTrajectory final : public Trajectory {
 public:
  FrozenTrajectory(const Trajectory& trajectory, Time instant)
      : begin_(trajectory.begin()), end_(trajectory.end()), T_v0_(trajectory.at(instant).T_v0) {}
  [[nodiscard]] Time begin() const override { return begin_; }
  [[nodiscard]] Time end() const override { return end_; }
  [[nodiscard]] TrajectoryState at(Time /*t*/) const override { return {T_v0_, Vector6d::Zero()}; }

 private:
  Time begin_, end_;
  SE3 T_v0_;
};

/// A scan and a trajectory with which the detector compensates less than it could, for ablations.
struct DetectorInput {
  std::shared_ptr<const LidarScan> scan;
  std::shared_ptr<const Trajectory> trajectory;
};

/// `none`: the sensor stands at its pose in the middle of the scan throughout. `not_of_rays`: the same, but
/// the points are given so that they come out in frame 0 as if compensated. `not_of_clouds`: the true motion,
/// but points given so that they come out as they would from the pose in the middle. `trajectory` must
/// outlive the result.
[[nodiscard]] DetectorInput withhold_motion(std::shared_ptr<const LidarScan> scan,
                                            const Trajectory& trajectory, Compensation compensation);

}  // namespace mapless::app
