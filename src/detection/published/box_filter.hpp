#pragma once

#include <vector>

#include <mapless/detection/parameters.hpp>
#include <mapless/detection/stages.hpp>
#include <mapless/lidar/lidar_scan.hpp>

namespace mapless::inline v1 {

/// Step 4: on the image of `scan` with dynamic = 1, a window of 3 lasers x 4 columns is compared pixel by
/// pixel (XNOR) with the pattern 0000 / 1111 / 0000; where more than score_threshold of the 12 pixels agree,
/// the dynamic pixels of its middle row are outliers. Columns wrap; beyond the top and bottom row all is 0.
/// `dynamic` has one element per return; so has the result, not_evaluated for static ones.
[[nodiscard]] std::vector<FilterVerdict> filter_boxes(const LidarScan& scan, const std::vector<char>& dynamic,
                                                      const BoxFilterParameters& parameters);

}  // namespace mapless
