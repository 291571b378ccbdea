#include <limits>

#include <mapless/trajectory/trajectory.hpp>

namespace mapless::inline v1 {

// Half the range of an int64, 146 years either way: the difference of any two times of the domain does not
// overflow.
Time StationaryTrajectory::begin() const {
  return Time::from_nanoseconds(std::numeric_limits<std::int64_t>::min() / 2);
}

Time StationaryTrajectory::end() const {
  return Time::from_nanoseconds(std::numeric_limits<std::int64_t>::max() / 2);
}

TrajectoryState StationaryTrajectory::at(Time) const { return {SE3(), Vector6d::Zero()}; }

}  // namespace mapless
