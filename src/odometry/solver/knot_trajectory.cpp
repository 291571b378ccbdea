#include "odometry/solver/knot_trajectory.hpp"

#include <string>

#include "trajectory/domain.hpp"
#include "trajectory/knot_states.hpp"

namespace mapless::inline v1 {
namespace {

const std::string& source() {
  static const std::string name = "lidar odometry";
  return name;
}

}  // namespace

Time KnotTrajectory::begin() const {
  return knots_.empty() ? Time::from_nanoseconds(1) : knots_.front().time;
}

Time KnotTrajectory::end() const { return knots_.empty() ? Time() : knots_.back().time; }

TrajectoryState KnotTrajectory::at(Time t) const {
  if (knots_.empty()) require_covered(t, begin(), end(), source());
  return state_between(knots_, t, source());
}

void KnotTrajectory::sample(Time first, Duration period, std::span<TrajectoryState> states) const {
  if (knots_.empty()) require_covered(first, begin(), end(), source());
  sample_between(knots_, first, period, source(), states);
}

}  // namespace mapless
