#pragma once

#include "lidar/self_check/scan_finding.hpp"
#include <mapless/lidar/lidar_scan.hpp>

namespace mapless::inline v1 {

/// Ranges of a laser against those of its firings before and after: their noise, and single ones that lie far
/// from both.
[[nodiscard]] ScanFinding check_noise(const LidarScan& scan);

}  // namespace mapless
