#pragma once

#include <vector>

#include <mapless/detection/parameters.hpp>
#include <mapless/lidar/lidar_scan.hpp>

namespace mapless::test {

/// Paper step 4 taken literally: the 0/1 image is laid out whole, and the 3 x 4 window is put on every place
/// of it. True for the returns that are outliers. For scans of at most one return a cell.
[[nodiscard]] std::vector<char> outliers_by_window(const LidarScan& scan, const std::vector<char>& dynamic,
                                                   const BoxFilterParameters& parameters);

}  // namespace mapless::test
