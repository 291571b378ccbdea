#pragma once

#include <string>
#include <vector>

#include <mapless/trajectory/trajectory.hpp>

namespace mapless::inline v1 {

/// The name of an odometry's trajectory in messages of TrajectoryDomainError.
[[nodiscard]] const std::string& odometry_source();

/// A Gaussian-process trajectory over knots that another object owns and appends to.
class KnotTrajectory final : public Trajectory {
 public:
  explicit KnotTrajectory(const std::vector<TrajectoryKnot>& knots) : knots_(knots) {}
  [[nodiscard]] Time begin() const override;
  [[nodiscard]] Time end() const override;
  [[nodiscard]] TrajectoryState at(Time t) const override;
  void sample(Time first, Duration period, std::span<TrajectoryState> states) const override;

 private:
  const std::vector<TrajectoryKnot>& knots_;
};

}  // namespace mapless
