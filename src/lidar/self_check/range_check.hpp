#pragma once

#include "lidar/self_check/scan_finding.hpp"
#include <mapless/lidar/lidar_scan.hpp>

namespace mapless::inline v1 {

/// Ranges against the limits of the sensor.
[[nodiscard]] ScanFinding check_ranges(const LidarScan& scan);

}  // namespace mapless
