#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "pictures/canvas.hpp"
#include <mapless/lidar/lidar_scan.hpp>

namespace mapless::app {

/// A scan with the labels to draw, and the true ones where known.
struct PicturedScan {
  LidarScan scan;
  std::vector<std::uint32_t> labels;
  std::optional<std::vector<std::uint32_t>> truth;
};

struct PictureOptions {
  bool bird_view = true;
  bool range_image = true;
  double extent_m = 50;  ///< from the sensor to the left and right edge of the bird's-eye view
  std::string title;
  /// If given, the bird's-eye view shows these points, in the scan's frame, in place of the scan.
  std::optional<PicturedScan> from_above = std::nullopt;
};

/// A labelled scan as a picture. Static points are grey. Dynamic ones have the colour of their object; with
/// `truth`, true positives are green, false positives orange and false negatives blue. The range image is
/// laid out by azimuth, straight ahead (x) in its middle; the bird's-eye view looks down the sensor's spin
/// axis, x to the right. `labels` and `truth` have one element per input record of the scan.
[[nodiscard]] Canvas draw_scan(const LidarScan& scan, const std::vector<std::uint32_t>& labels,
                               const std::optional<std::vector<std::uint32_t>>& truth,
                               const PictureOptions& options);

}  // namespace mapless::app
