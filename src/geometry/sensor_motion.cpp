#include "geometry/sensor_motion.hpp"

#include <algorithm>
#include <span>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

namespace mapless {

SensorMotion::SensorMotion(const LidarScan& scan, const Trajectory& trajectory)
    : trajectory_(trajectory), start_(scan.start), period_ns_(scan.column_period.nanoseconds()) {
  // The extremes are asked first and in order, so that which instant an error names does not depend on
  // threads.
  if (scan.columns > 0) {
    (void)trajectory.at(scan.column_time(0));
    (void)trajectory.at(scan.column_time(scan.columns - 1));
  }
  if (!scan.returns.empty()) {
    const auto [first, last] =
        std::minmax_element(scan.returns.begin(), scan.returns.end(),
                            [](const LidarReturn& a, const LidarReturn& b) { return a.time_ns < b.time_ns; });
    (void)trajectory.at(scan.time_of(*first));
    (void)trajectory.at(scan.time_of(*last));
  }
  const auto columns = static_cast<std::size_t>(scan.columns);
  column_states.resize(columns);
  column_T_0v.resize(columns);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, columns, 64), [&](const auto& range) {
    trajectory.sample(scan.column_time(static_cast<int>(range.begin())), scan.column_period,
                      std::span(column_states).subspan(range.begin(), range.size()));
    for (std::size_t c = range.begin(); c < range.end(); ++c)
      column_T_0v[c] = column_states[c].T_v0.inverse();
  });
}

TrajectoryState SensorMotion::exact_state(std::int32_t time_ns) const {
  return trajectory_.at(start_ + Duration::from_nanoseconds(time_ns));
}

}  // namespace mapless
