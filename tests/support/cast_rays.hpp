#pragma once

#include <functional>
#include <memory>
#include <optional>

#include <mapless/lidar/lidar_scan.hpp>
#include <mapless/trajectory/trajectory.hpp>

namespace mapless::test {

/// A lidar with what makes real ones awkward: azimuth offsets of several columns that differ from laser to
/// laser, beams that start beside and above each other, clockwise, 10 Hz.
[[nodiscard]] std::shared_ptr<const LidarModel> awkward_model(int lasers, int columns);

/// A motion of constant body-centric velocity: T_v0(t) = exp(t varpi^) T_v0(0).
class ScrewTrajectory final : public Trajectory {
 public:
  ScrewTrajectory(const SE3& T_v0_start, const Vector6d& varpi, Time begin, Time end)
      : T_v0_start_(T_v0_start), varpi_(varpi), begin_(begin), end_(end) {}
  [[nodiscard]] Time begin() const override { return begin_; }
  [[nodiscard]] Time end() const override { return end_; }
  [[nodiscard]] TrajectoryState at(Time t) const override;

 private:
  SE3 T_v0_start_;
  Vector6d varpi_;
  Time begin_;
  Time end_;
};

/// How far a ray (origin and unit direction in frame 0) goes; absent where it meets nothing.
using RangeOfRay = std::function<std::optional<double>(const Eigen::Vector3d&, const Eigen::Vector3d&)>;

/// One turn of a sensor that moves along `trajectory`, every ray cast from its own pose at its own instant.
[[nodiscard]] LidarScan cast_rays(std::shared_ptr<const LidarModel> model, Time start,
                                  const Trajectory& trajectory, const RangeOfRay& range_of_ray);

}  // namespace mapless::test
