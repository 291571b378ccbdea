#include "geometry/sensor_motion.hpp"

#include <algorithm>
#include <span>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

namespace mapless::inline v1 {

SensorMotion::SensorMotion(const LidarScan& scan, const Trajectory& trajectory)
    : trajectory_(trajectory), start_(scan.start), period_ns_(scan.column_period.nanoseconds()) {
  // The extremes are evaluated first, in a fixed order: which instant an error names must not depend on
  // threads.
  if (scan.columns > 0) {
    (void)trajectory.at(scan.column_time(0));
    (void)trajectory.at(scan.column_time(scan.columns - 1));
  }
  if (!scan.returns.empty()) {
    std::int32_t first_ns = scan.returns.front().time_ns, last_ns = first_ns;
    for (const LidarReturn& r : scan.returns) {
      first_ns = std::min(first_ns, r.time_ns);
      last_ns = std::max(last_ns, r.time_ns);
    }
    (void)exact_state(first_ns);
    (void)exact_state(last_ns);
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
