#pragma once

#include "lidar/self_check/scan_finding.hpp"
#include <mapless/lidar/lidar_model.hpp>
#include <mapless/lidar/lidar_scan.hpp>

namespace mapless::inline v1 {

/// Times of the points against the angle turned: how long the sensor took for a turn by its times, over how
/// long by its columns. Only of times that the sensor measured: others are made of the columns.
[[nodiscard]] ScanFinding check_point_times(const LidarScan& scan);

/// How fast the sensor turns, as its model says.
[[nodiscard]] ScanFinding check_rate(const LidarModel& model);

}  // namespace mapless
