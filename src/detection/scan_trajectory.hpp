#pragma once

#include <vector>

#include <mapless/lidar/lidar_scan.hpp>
#include <mapless/trajectory/trajectory.hpp>

namespace mapless::inline v1 {

/// The motion of the sensor during one scan, as it was known when the scan was compensated: its states at the
/// columns, and from the nearest of these at constant body-centric velocity. The domain reaches one scan
/// period beyond either end.
class ScanTrajectory final : public Trajectory {
 public:
  /// `column_states` as in CompensatedScan, of `scan`; at least one.
  ScanTrajectory(const LidarScan& scan, std::vector<TrajectoryState> column_states);
  [[nodiscard]] Time begin() const override;
  [[nodiscard]] Time end() const override;
  [[nodiscard]] TrajectoryState at(Time t) const override;

 private:
  [[nodiscard]] Duration scan_period() const;

  Time start_;
  Duration column_period_;
  std::vector<TrajectoryState> states_;
};

}  // namespace mapless
