#pragma once

#include <vector>

#include <mapless/lidar/lidar_scan.hpp>

namespace mapless::inline v1 {

/// Which rays without a return met nothing within range, where the recording does not say why they have none:
/// drivers report the sky and a dark or glassy surface alike. An element per cell of the scan; empty where
/// the recording says it: some cell has ReturnCode::nothing.
///
/// A ray met nothing if no ray within 7.5 degrees to the side and 2 up and down (the next lasers at least)
/// has a return, and some lower laser of its column has one. The sky is wide; panes and dark paint are seldom
/// as wide, and some of their rays return. Below what returns, and in columns that are empty, the sensor may
/// be covered, or its packets lost. Wrong where something nearer than the least range covers upper lasers. A
/// sensor on its head has no sky. Measured: docs/notebook/detection.md, "Missing returns".
[[nodiscard]] std::vector<bool> open_sky(const LidarScan& scan);

}  // namespace mapless
