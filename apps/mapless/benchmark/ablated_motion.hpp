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

/// A scan and a trajectory that switch off a part of the detector's motion compensation, for ablations.
struct DetectorInput {
  std::shared_ptr<const LidarScan> scan;
  std::shared_ptr<const Trajectory> trajectory;
};

/// `none`: the sensor keeps its pose at the middle of the scan throughout. `not_of_rays`: the same, with
/// points moved so that the detector places them in frame 0 as if they were compensated. `not_of_clouds`: the
/// true motion, with points moved so that the detector places them as from the pose at the middle of the
/// scan.
[[nodiscard]] DetectorInput ablate_motion(std::shared_ptr<const LidarScan> scan,
                                          std::shared_ptr<const Trajectory> trajectory,
                                          Compensation compensation);

}  // namespace mapless::app
