#include "odometry/solver/knot_trajectory.hpp"

#include "trajectory/domain.hpp"
#include "trajectory/knot_states.hpp"

namespace mapless::inline v1 {

const std::string& odometry_source() {
  static const std::string name = "lidar odometry";
  return name;
}

Time KnotTrajectory::begin() const {
  return knots_.empty() ? Time::from_nanoseconds(1) : knots_.front().time;
}

Time KnotTrajectory::end() const { return knots_.empty() ? Time() : knots_.back().time; }

TrajectoryState KnotTrajectory::at(Time t) const {
  if (knots_.empty()) require_covered(t, begin(), end(), odometry_source());
  return state_between(knots_, t, odometry_source());
}

void KnotTrajectory::sample(Time first, Duration period, std::span<TrajectoryState> states) const {
  if (knots_.empty()) require_covered(first, begin(), end(), odometry_source());
  sample_between(knots_, first, period, odometry_source(), states);
}

}  // namespace mapless
