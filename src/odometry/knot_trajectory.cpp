#include "odometry/knot_trajectory.hpp"

#include <algorithm>

#include "trajectory/domain.hpp"

namespace mapless {

Time KnotTrajectory::begin() const {
  return knots_.empty() ? Time::from_nanoseconds(1) : knots_.front().time;
}

Time KnotTrajectory::end() const { return knots_.empty() ? Time() : knots_.back().time; }

TrajectoryState KnotTrajectory::at(Time t) const {
  require_covered(t, begin(), end(), "lidar odometry");
  const auto second =
      std::upper_bound(knots_.begin() + 1, knots_.end() - 1, t,
                       [](Time time, const TrajectoryKnot& knot) { return time < knot.time; });
  return interpolate(*(second - 1), *second, t);
}

}  // namespace mapless
