#pragma once

#include <vector>

#include <mapless/trajectory/trajectory.hpp>

namespace mapless::inline v1 {

/// A Gaussian-process trajectory over knots that somebody else owns and adds to.
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
