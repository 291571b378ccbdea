#include "detection/scan_trajectory.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

namespace mapless::inline v1 {

ScanTrajectory::ScanTrajectory(const LidarScan& scan, std::vector<TrajectoryState> column_states)
    : start_(scan.start), column_period_(scan.column_period), states_(std::move(column_states)) {}

Time ScanTrajectory::begin() const { return start_ - scan_period(); }
Time ScanTrajectory::end() const { return start_ + scan_period() + scan_period(); }

Duration ScanTrajectory::scan_period() const {
  return Duration::from_nanoseconds(static_cast<std::int64_t>(states_.size()) * column_period_.nanoseconds());
}

TrajectoryState ScanTrajectory::at(Time t) const {
  const double columns = (t - start_).seconds() / column_period_.seconds();
  const auto last = static_cast<double>(states_.size() - 1);
  const double nearest = std::clamp(std::round(columns), 0.0, last);
  const TrajectoryState& state = states_[static_cast<std::size_t>(nearest)];
  const double dt = (columns - nearest) * column_period_.seconds();
  return {SE3::exp(dt * state.varpi) * state.T_v0, state.varpi};
}

}  // namespace mapless
